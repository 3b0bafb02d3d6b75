// Elevation. A number is a height in metres; heights average as they are, over the samples that exist: a void
// must not pull the surface down. Planes: height times weight; where samples are wide what its floats miss
// (wide_value.h); weight (1 data, 0 void); for bounds the least and the greatest height of the finest level
// under a texel, which are floats rounded outward. Stored as floats, halves, or 16-bit codes with one quantum
// for all of the layer, so that both tiles at an edge decode equal; a texel without any data is NaN or code
// 0, never a height.

#include "builder/channels/elevation/elevation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/elevation/height_forms.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/samples/wide_value.h"
#include "builder/channels/shared/declared_unit.h"
#include "builder/channels/shared/format_of_channels.h"
#include "builder/text/number_text.h"

namespace vt::channels {
namespace {

// No land or sea floor on the Earth is lower or higher, in metres.
constexpr float kLowestPlausible = -12000.0F;
constexpr float kHighestPlausible = 9000.0F;
constexpr float kNowhere = std::numeric_limits<float>::infinity();  // the least of no heights; its negative is their greatest

// How heights are held by the formats that are taken.
enum class HeightForm : std::uint8_t { kCodes, kHalves, kFloats };

struct HeightChoices {
  TexelFormat format = TexelFormat::kR32Float;
  bool is_wide = false;       // of some source of the layer
  CodedHeights codes;         // of kR16
  bool with_bounds = false;   // the part "bounds"
  bool with_surface = false;  // measured against the finest level
  std::optional<float> fill;  // stored instead of "no data"
  double scale = 1.0;         // metres = offset + scale * sample
  double offset = 0.0;

  [[nodiscard]] HeightForm form() const {
    return format == TexelFormat::kR16 ? HeightForm::kCodes : format == TexelFormat::kR16Float ? HeightForm::kHalves : HeightForm::kFloats;
  }
};

class ElevationCodec final : public ChannelCodec {
 public:
  ElevationCodec(const SampleLayout& layout, const HeightChoices& choices) : layout_(weighed_by_coverage(layout)), choices_(choices) {
    rules_ = {PlaneRule::kLinear, PlaneRule::kLinear};
    if (choices.is_wide) {
      rules_.insert(rules_.begin() + kRemainder, PlaneRule::kRemainder);
      rules_version_ = 2;  // heights were floats before they were means
    }
    source_planes_ = static_cast<int>(rules_.size());
    weight_ = rules_.size() - 1;
    // Codes may be far finer than floats of their heights.
    if (choices.is_wide && choices.format == TexelFormat::kR16) bounds_origin_ = choices.codes.offset;
    is_surface_ = true;
    Part heights{.format = choices.format, .texel_format = choices.format, .components = {"height"}, .unit = "m"};
    if (choices.format == TexelFormat::kR16) {
      heights.ranges[0] = {.scale = choices.codes.quantum, .offset = choices.codes.offset};
      heights.zero_is_nodata = true;
    }
    // Whoever reads the heights can tell that some of them may be none.
    if (choices.fill) heights.metadata_json = R"({"filled_m": )" + text::number_text(static_cast<double>(*choices.fill)) + "}";
    parts_.push_back(heights);
    measures_.push_back({.name = "height", .unit = "m"});
    measures_surface_ = choices.with_surface;
    losses_.push_back({"the height is below " + text::number_text(static_cast<double>(kLowestPlausible)) + " m or above " +
                       text::number_text(static_cast<double>(kHighestPlausible)) +
                       " m, as nowhere on the Earth, and is stored and averaged as it is; if it means no data, say so with `nodata`"});
    keeps_numbers_ = choices.scale == 1.0 && choices.offset == 0.0;
    centre_range_ = range_of(choices);
    if (!choices.with_bounds) return;
    rules_.push_back(PlaneRule::kLeast);
    rules_.push_back(PlaneRule::kGreatest);
    Part bounds = heights;
    bounds.suffix = "bounds";
    bounds.format = bounds.texel_format = format_of_channels(choices.format, 2);
    bounds.components = {"least height", "greatest height"};
    bounds.ranges[1] = bounds.ranges[0];
    bounds.starts_above_base = true;  // one height is its own bounds
    parts_.push_back(std::move(bounds));
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    return visit_sample_type(layout_.type, [&]<class T>(std::type_identity<T>) { return decode<T>(samples, count, out); });
  }

  void derive_row(std::int64_t count, const PlaneRow& planes) const override {
    if (!choices_.with_bounds) return;
    const float* const weight = planes[weight_];
    float* const least = planes[weight_ + 1];
    float* const greatest = planes[weight_ + 2];
    ConstPlaneRow row{};
    std::copy_n(planes.begin(), weight_ + 1, row.begin());
    for (std::int64_t i = 0; i < count; ++i) {
      const bool is_void = !(weight[i] > 0.0F) && !choices_.fill;
      if (choices_.is_wide) {
        const double value = wide_height(row, i);
        least[i] = is_void ? kNowhere : float_below(value - bounds_origin_);
        greatest[i] = is_void ? -kNowhere : float_above(value - bounds_origin_);
      } else {
        const float value = narrow_height(row, i);
        least[i] = is_void ? kNowhere : value;
        greatest[i] = is_void ? -kNowhere : value;
      }
    }
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    switch (choices_.form()) {
      case HeightForm::kCodes:
        return encode(choices_.codes, part, rows, count, out);
      case HeightForm::kHalves:
        return encode(HalfHeights{}, part, rows, count, out);
      case HeightForm::kFloats:
        return encode(FloatHeights{}, part, rows, count, out);
    }
    return {};
  }

  // A texel of the kernel "point" may have bounds although its own height is void.
  bool has_data(std::size_t part, const ConstPlaneRow& planes, std::int64_t count) const override {
    if (ChannelCodec::has_data(0, planes, count)) return true;
    if (part == 0) return false;
    const float* const least = planes[weight_ + 1];
    const float* const greatest = planes[weight_ + 2];
    for (std::int64_t i = 0; i < count; ++i) {
      const bool is_nothing = !(least[i] <= greatest[i]);
      if (!is_nothing && !is_fill(least[i], greatest[i])) return true;
    }
    return false;
  }

  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    const std::int64_t samples = part == 0 ? count : 2 * count;
    switch (choices_.form()) {
      case HeightForm::kCodes:
        return repeat(CodedHeights::kNone, texels, samples);
      case HeightForm::kHalves:
        return repeat(HalfHeights::kNone, texels, samples);
      case HeightForm::kFloats:
        return repeat(FloatHeights::kNone, texels, samples);
    }
  }

  // Bounds have none: they are rounded outward on purpose.
  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    if (part != 0) return;
    const ComponentRange& range = parts_[0].ranges[0];
    for (std::int64_t i = 0; i < count; ++i) {
      const float weight = reference[weight_][i];
      if (!(weight > 0.0F)) continue;
      const double wanted = choices_.is_wide ? wide_height(reference, i) : static_cast<double>(reference[0][i]) / weight;
      errors[0].add(range.offset + range.scale * static_cast<double>(stored[i]) - wanted);
    }
  }

  void count_losses(const ConstPlaneRow& row, bool, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    const float* const sum = row[0];
    const float* const weight = row[weight_];
    // Both are 0 for a texel without data.
    const auto is_implausible = [&](std::int64_t i) {
      return (sum[i] < kLowestPlausible * weight[i]) | (sum[i] > kHighestPlausible * weight[i]);
    };
    bool any = false;
    for (std::int64_t i = 0; i < count; ++i) any |= is_implausible(i);
    for (std::int64_t i = 0; any && i < count; ++i)
      if (is_implausible(i)) counts[0].add(x + i, y);
  }

 private:
  // Least and greatest height that the format holds.
  [[nodiscard]] CentreRange range_of(const HeightChoices& choices) const {
    const auto range = [&](double least, double greatest) { return CentreRange{least, greatest, bounds_origin_}; };
    switch (choices.form()) {
      case HeightForm::kCodes:
        return range(choices.codes.value(1.0), choices.codes.value(CodedHeights::kLargestCode));
      case HeightForm::kHalves:
        return range(-HalfHeights::kLargest, HalfHeights::kLargest);
      case HeightForm::kFloats:
        return range(std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max());
    }
    return {};
  }

  static constexpr std::size_t kRemainder = 1;  // the plane beside the heights, when they are wide

  // The bounds that derive_row() gives a texel that is filled.
  [[nodiscard]] bool is_fill(float least, float greatest) const {
    if (!choices_.fill) return false;
    const double fill = static_cast<double>(*choices_.fill) - bounds_origin_;
    return least == float_below(fill) && greatest == float_above(fill);
  }

  // A texel's height, or what it is filled with.
  [[nodiscard]] float narrow_height(const ConstPlaneRow& row, std::int64_t i) const {
    const float weight = row[weight_][i];
    return weight == 1.0F ? row[0][i] : weight > 0.0F ? row[0][i] / weight : choices_.fill.value_or(0.0F);
  }
  [[nodiscard]] double wide_height(const ConstPlaneRow& row, std::int64_t i) const {
    const double weight = row[weight_][i];
    const double sum = static_cast<double>(row[0][i]) + static_cast<double>(row[kRemainder][i]);
    return weight == 1.0 ? sum : weight > 0.0 ? sum / weight : static_cast<double>(choices_.fill.value_or(0.0F));
  }

  template <class Form>
  Result<void> encode(const Form& form, std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const {
    using Sample = typename Form::Sample;
    const auto put = [&](std::int64_t i, Sample sample) { std::memcpy(out + i * std::int64_t{sizeof sample}, &sample, sizeof sample); };
    const float* const height = rows.here[0];
    const float* const weight = rows.here[weight_];
    bool all_fit = true;
    Sample sample{};
    if (part == 1) {
      const float* const least = rows.here[weight_ + 1];
      const float* const greatest = rows.here[weight_ + 2];
      const Form bounds = form.from(bounds_origin_);
      for (std::int64_t i = 0; i < count; ++i) {
        const bool is_void = !(least[i] <= greatest[i]);
        const bool low_fits = bounds.below(least[i], sample);
        put(2 * i, is_void ? Form::kNone : sample);
        const bool high_fits = bounds.above(greatest[i], sample);
        put(2 * i + 1, is_void ? Form::kNone : sample);
        if (!is_void && !low_fits) return misfit(bounds_origin_ + static_cast<double>(least[i]));
        if (!is_void && !high_fits) return misfit(bounds_origin_ + static_cast<double>(greatest[i]));
      }
      return {};
    }
    const auto put_heights = [&](const auto& height_of) {
      for (std::int64_t i = 0; i < count; ++i) {
        const bool is_void = !(weight[i] > 0.0F) && !choices_.fill;
        const bool fits = form.nearest(height_of(i), sample);
        all_fit = all_fit && (fits || is_void);
        put(i, is_void ? Form::kNone : sample);
      }
    };
    if (choices_.is_wide) {
      put_heights([&](std::int64_t i) { return wide_height(rows.here, i); });
    } else if (rows.opaque) {
      for (std::int64_t i = 0; i < count; ++i) {
        all_fit = form.nearest(height[i], sample) && all_fit;
        put(i, sample);
      }
    } else {
      put_heights([&](std::int64_t i) { return narrow_height(rows.here, i); });
    }
    for (std::int64_t i = 0; !all_fit && i < count; ++i) {
      const bool has_height = weight[i] > 0.0F || choices_.fill;
      const double value = choices_.is_wide ? wide_height(rows.here, i) : static_cast<double>(narrow_height(rows.here, i));
      if (has_height && !form.nearest(value, sample)) return misfit(value);
    }
    return {};
  }

  [[nodiscard]] Result<void> misfit(double height) const {
    const std::string what = "height " + text::number_text(height) + " m ";
    const std::string else_nodata = "; if it is none, say with `nodata` which sample value means no data";
    switch (choices_.form()) {
      case HeightForm::kCodes:
        return fail(ErrorCode::kInvalidData, what + "is outside " + text::number_text(choices_.codes.value(1.0)) + " to " +
                                                 text::number_text(choices_.codes.value(CodedHeights::kLargestCode)) +
                                                 " m, what r16 holds in steps of " + text::number_text(choices_.codes.quantum) +
                                                 " m; give `range` LOW,HIGH around all heights, or use r32f" + else_nodata);
      case HeightForm::kHalves:
        return fail(ErrorCode::kInvalidData, what + "is beyond 65504 m, the most that r16f holds; use r16 or r32f" + else_nodata);
      case HeightForm::kFloats:
        return fail(ErrorCode::kInvalidData, what + "is the mean of samples too large to add" + else_nodata);
    }
    return {};
  }

  template <class Sample>
  static void repeat(Sample sample, std::byte* out, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) std::memcpy(out + i * std::int64_t{sizeof sample}, &sample, sizeof sample);
  }

  template <class T>
  bool decode(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    if (choices_.scale == 1.0 && choices_.offset == 0.0) return decode_as<T>(samples, count, out, [](T sample) { return sample; });
    return decode_as<T>(samples, count, out, [this](T sample) { return choices_.offset + choices_.scale * static_cast<double>(sample); });
  }

  template <class T, class HeightOf>
  bool decode_as(const std::byte* samples, std::int64_t count, const PlaneRow& out, const HeightOf& height_of_sample) const {
    const TypedNodataRange<T> nodata = typed_nodata_range<T>(layout_);
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      T sample;
      std::memcpy(&sample, samples + i * static_cast<std::int64_t>(sizeof sample), sizeof sample);
      const auto height = height_of_sample(sample);
      const auto nearest = static_cast<float>(height);
      bool is_void = nodata.contains(sample);
      if constexpr (std::is_floating_point_v<T>) is_void = is_void || !std::isfinite(nearest);
      out[0][i] = is_void ? 0.0F : nearest;
      if (choices_.is_wide) out[kRemainder][i] = is_void ? 0.0F : remainder_of(static_cast<double>(height), nearest);
      out[weight_][i] = is_void ? 0.0F : 1.0F;
      opaque = opaque && !is_void;
    }
    return opaque;
  }

  SampleLayout layout_;
  HeightChoices choices_;
  std::size_t weight_ = 1;      // the plane
  double bounds_origin_ = 0.0;  // planes of bounds are heights less this
};

// What samples of a type can say, less one value where 65536 of them would leave no code for "no data".
std::optional<std::array<double, 2>> range_of(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return {{0.0, 255.0}};
    case SampleType::kInt8:
      return {{-128.0, 127.0}};
    case SampleType::kUint16:
      return {{0.0, 65534.0}};
    case SampleType::kInt16:
      return {{-32767.0, 32767.0}};
    case SampleType::kUint32:
    case SampleType::kInt32:
    case SampleType::kFloat32:
    case SampleType::kFloat64:
      return std::nullopt;
  }
  return std::nullopt;
}

// Codes 1 to 65535 that hold `range` on multiples of `quantum`.
bool fits(const std::array<double, 2>& range, double quantum) {
  return std::ceil(range[1] / quantum) - std::floor(range[0] / quantum) <= CodedHeights::kLargestCode - 1.0;
}

// The smallest power of two that does; powers of two make every height that is decoded exact.
double finest_quantum(const std::array<double, 2>& range) {
  double quantum = 0x1p-16;
  while (!fits(range, quantum)) quantum *= 2.0;
  return quantum;
}

// Metres of a sample: what the user says, else what the file declares, else the sample itself.
Result<void> choose_height_of_sample(const Options& options, const SampleLayout& layout, HeightChoices& choices) {
  constexpr double kMost = std::numeric_limits<float>::max();
  VT_ASSIGN(const std::optional<double> scale, number_of(options, "input-scale", -kMost, kMost));
  VT_ASSIGN(const std::optional<double> offset, number_of(options, "input-offset", -kMost, kMost));
  const auto given_unit = options.find("input-unit");
  const std::string unit = given_unit != options.end() ? given_unit->second : layout.unit;
  const std::optional<double> metres = unit.empty() ? std::optional(1.0) : metres_of_unit(unit);
  if (!metres && given_unit != options.end())
    return fail(ErrorCode::kUsage,
                "option input-unit: '" + unit + "' is no unit of length that is known; use m, ft, us-ft, cm, or metres as in \"0.3048 m\"");
  if (!metres)
    return fail(ErrorCode::kInvalidData, "declares its heights in '" + unit +
                                             "', which is no unit of length that is known; say what one is with input-unit "
                                             "(m, ft, us-ft, cm, or metres as in \"0.3048 m\")");
  if (layout.counts_down && !scale)
    return fail(ErrorCode::kInvalidData,
                "declares depths, which count downward from their datum; say with input-scale -1 that they are to become "
                "heights, or with input-scale 1 that they are heights already");
  const double factor = scale.value_or(layout.scale.value_or(1.0));
  if (factor == 0.0)
    return scale ? fail(ErrorCode::kUsage, "option input-scale: 0 makes all heights equal")
                 : fail(ErrorCode::kInvalidData, "declares a scale of 0, which makes all heights equal; give another with input-scale");
  choices.scale = factor * *metres;
  choices.offset = offset.value_or(layout.offset.value_or(0.0)) * *metres;
  return {};
}

Result<CodedHeights> choose_codes(const Options& options, const SampleLayout& layout, const HeightChoices& choices) {
  std::optional<std::array<double, 2>> range = layout.range;
  if (const auto samples = range_of(layout.type); !range && samples) {
    const double ends[] = {choices.offset + choices.scale * (*samples)[0], choices.offset + choices.scale * (*samples)[1]};
    range = {{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}};
  }
  if (!range)
    return fail(ErrorCode::kUsage, std::string("heights from ") + sample_name(layout.type) +
                                       " samples stored as r16 need to know from where to where they go; give `range` LOW,HIGH in metres");
  constexpr double kFarthest = 1e9;  // metres
  if (!((*range)[0] < (*range)[1]) || std::abs((*range)[0]) > kFarthest || std::abs((*range)[1]) > kFarthest)
    return fail(ErrorCode::kUsage, "a range of heights is LOW,HIGH in metres with LOW below HIGH, found " + text::number_text((*range)[0]) +
                                       "," + text::number_text((*range)[1]));
  VT_ASSIGN(const std::optional<double> asked, number_of(options, "quantum", 1e-5, 1e6));
  const double quantum = asked.value_or(finest_quantum(*range));
  if (!fits(*range, quantum))
    return fail(ErrorCode::kUsage, "steps of " + text::number_text(quantum) + " m from " + text::number_text((*range)[0]) + " to " +
                                       text::number_text((*range)[1]) +
                                       " m are more than the 65535 codes of r16; the finest power of two is " +
                                       text::number_text(finest_quantum(*range)) + " m, or give a smaller `range`");
  return CodedHeights{.offset = (std::floor((*range)[0] / quantum) - 1.0) * quantum, .quantum = quantum};
}

constexpr std::array kFormats{TexelFormat::kR32Float, TexelFormat::kR16, TexelFormat::kR16Float};

MadeCodec make_elevation(const ChannelSettings& settings, const SampleLayout& layout) {
  HeightChoices choices{.format = settings.format, .is_wide = settings.samples_are_wide};
  if (layout.value_bands != 1)
    return fail(ErrorCode::kUnsupported,
                "elevation needs exactly one band, found " + std::to_string(layout.value_bands) + "; choose with `bands`");
  VT_CHECK(choose_height_of_sample(settings.options, layout, choices));
  if (choices.format == TexelFormat::kR16) {
    VT_ASSIGN(choices.codes, choose_codes(settings.options, layout, choices));
  } else if (settings.options.contains("quantum") || layout.range) {
    return fail(ErrorCode::kUsage, "a quantum or a range of heights is for layers stored as r16, this one is " +
                                       std::string(format_info(settings.format).name));
  }
  VT_ASSIGN(choices.with_surface, flag_of(settings.options, "surface-error", false));
  VT_ASSIGN(choices.with_bounds, flag_of(settings.options, "bounds", false));
  constexpr std::array<std::string_view, 1> kNoFill{"none"};
  if (!choice_of(settings.options, "fill", "none", kNoFill)) {
    VT_ASSIGN(const std::optional<double> fill, number_of(settings.options, "fill", -1e6, 1e6));
    if (fill) choices.fill = static_cast<float>(*fill);
  }
  return std::make_unique<const ElevationCodec>(layout, choices);
}

// Measured of terrain models, and of their bounds.
double stored_ratio(TexelFormat format) {
  if (format == TexelFormat::kR32Float) return 0.45;
  if (format == TexelFormat::kRg32Float) return 0.55;
  return kUnmeasuredRatio;
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"input-scale", "FACTOR", "height = offset + scale * sample, in `input-unit` (default: what the file declares for the band, else 1)"},
    {"input-offset", "HEIGHT", "height of the sample 0, see `input-scale` (default: what the file declares, else 0)"},
    {"input-unit", "m|ft|us-ft|cm|...",
     "unit of the input's heights; the layer's are metres. Also metres, as in \"0.3048 m\" (default: what the file declares, else m)"},
    {"quantum", "METRES",
     "step of the codes of r16, which hold `range` (of 8 and 16 bit integers: all that the type can say) in 65535 of them (default: the "
     "finest power of two that does)"},
    {"bounds", "yes|no",
     "store the least and greatest height under every texel of coarser levels too, as NAME/bounds; twice the data of all levels but the "
     "finest, for programs that displace or cull (default: no)"},
    {"surface-error", "yes|no",
     "measure how far the surface through every coarser level lies from the finest, into the layer's metadata (\"surface\"); reads all "
     "tiles again after the build (default: no)"},
    {"fill", "METRES|none",
     "height that is stored where there are no data; means of coarser levels leave it out; the metadata say so: \"filled_m\" (default: "
     "none)"},
});

}  // namespace

constinit const ChannelKind kElevationKind{
    .type = ChannelType::kElevation,
    .name = "elevation",
    .unit = "m",
    .options = kOptions,
    .has_one_value = true,
    .uses_declared_scale = true,
    .holds_heights = true,
    .concern = source::Concern::kHeights,
    .why_only_box = "negative lobes would put heights outside the range of the terrain",
    .may_be_picked = true,
    .formats = always_formats<kFormats>,
    .why_not_format = [](TexelFormat,
                         const Options&) { return std::string_view(": eight bits or a block of 4x4 are too coarse for heights"); },
    .usual_format = [](SampleType, bool) { return TexelFormat::kR32Float; },
    .stored_ratio = stored_ratio,
    .carry_ratio = 0.25,
    .absent = Absent::kFill,
    .make = make_elevation,
};

}  // namespace vt::channels
