// Illumination: light maps of high dynamic range, such as the lamps of a city by night. A number is linear
// light; light adds up, so it averages as it is, weighted by coverage. Planes: red, green, blue light times
// weight, then the weight. A sample below 0 is an error of the data and counts as 0, for there is no dark
// lamp; what is not finite is no data.
//
// The total of light over a level is the same at every level. Formats with a fourth component store light as
// it is and coverage beside it, so the total is of light times coverage. The others have no place for
// coverage: they store that product, and where nothing is known there is no light. Light above a format's
// largest number becomes that number; how much was cut off is reported of every level.
//
// What is stored is light divided by one scale for the whole layer, which readers find as the components'
// scale: light in small units (by night, 1e-7 to 1e-3 W/(m2 sr)) would vanish below what halves and rgb9e5
// can say. A power of two moves exponents and rounds nothing.

#include "builder/channels/illumination/illumination.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/shared/finite_rows.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/radiance_unit.h"
#include "builder/channels/shared/srgb.h"
#include "builder/channels/shared/unblocked_format.h"
#include "builder/text/number_text.h"
#include "store/texel/half.h"
#include "store/texel/rgb9e5.h"

namespace vt::channels {
namespace {

constexpr std::size_t kWeight = 3;
constexpr float kLargestHalf = 65504.0F;
constexpr float kLeastStored = 0x1p-25F;  // halves and rgb9e5 round what is not above it to nothing

struct Light {
  Transfer transfer = Transfer::kLinear;  // of the input's codes
  double scale = 1.0;                     // light of the full code, or of the number 1
  double stored_scale = 1.0;              // light of the number 1 as it is stored
  std::string unit;
};

bool is_code(SampleType type) { return type == SampleType::kUint8 || type == SampleType::kUint16; }

float largest_number(TexelFormat format) {
  if (format == TexelFormat::kRgba32Float) return std::numeric_limits<float>::max();
  return format == TexelFormat::kRgb9e5 ? store::kRgb9e5Max : kLargestHalf;
}

template <class T>
void put_texel(std::byte* out, std::int64_t i, const T& texel) {
  std::memcpy(out + i * static_cast<std::int64_t>(sizeof texel), &texel, sizeof texel);
}

class IlluminationCodec final : public ChannelCodec {
 public:
  IlluminationCodec(const SampleLayout& layout, const Light& light, TexelFormat format)
      : layout_(layout),
        texels_(unblocked_format(format)),
        scale_(light.scale),
        stored_scale_(light.stored_scale),
        per_scale_(static_cast<float>(1.0 / light.stored_scale)),
        limit_(largest_number(format)) {
    source_planes_ = 4;
    rules_.assign(4, PlaneRule::kLinear);
    has_coverage_ = format == TexelFormat::kRgba16Float || format == TexelFormat::kRgba32Float;
    parts_.push_back({.format = format, .texel_format = texels_, .components = {"red", "green", "blue"}, .unit = light.unit});
    if (has_coverage_) parts_[0].components.emplace_back("coverage");
    for (std::size_t c = 0; c < 3; ++c) parts_[0].ranges[c].scale = stored_scale_;
    describe_losses(format, light.unit);
    if (format == TexelFormat::kBc6h) rules_version_ = 2;  // blocks once kept less of the light
    measures_ = {{.name = "light", .unit = light.unit, .is_light = true}, {.name = "clipped light", .unit = light.unit}};
    for (std::size_t b = 0; b < nodata_.size(); ++b) nodata_[b] = nodata_range(layout, b);
    if (!is_code(layout.type)) return;
    light_of_code_.resize(layout.type == SampleType::kUint8 ? 256 : 65536);
    const double full = layout.full_value();
    for (std::size_t c = 0; c < light_of_code_.size(); ++c)
      light_of_code_[c] = static_cast<float>(light.scale * linear_from_code(light.transfer, std::min(static_cast<double>(c) / full, 1.0)));
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    switch (layout_.type) {
      case SampleType::kUint8:
        return decode_codes<std::uint8_t>(samples, count, out);
      case SampleType::kUint16:
        return decode_codes<std::uint16_t>(samples, count, out);
      case SampleType::kFloat32:
        if (!layout_.has_alpha && !layout_.nodata) return decode_floats(samples, count, out);
        break;
      case SampleType::kInt8:
      case SampleType::kInt16:
      case SampleType::kUint32:
      case SampleType::kInt32:
      case SampleType::kFloat64:
        break;
    }
    return decode_any(samples, count, out);
  }

  Result<void> encode_row(std::size_t, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    for (std::size_t c = 0; c < 3; ++c)
      if (!all_finite(rows.here[c], count))
        return fail(ErrorCode::kInvalidData,
                    "light is the mean of samples too large to add; if they are none, say with `nodata` which sample value means no data");
    if (texels_ == TexelFormat::kRgb9e5) {
      for (std::int64_t i = 0; i < count; ++i)
        put_texel(out, i, store::pack_rgb9e5(rows.here[0][i] * per_scale_, rows.here[1][i] * per_scale_, rows.here[2][i] * per_scale_));
    } else if (texels_ == TexelFormat::kRgba32Float) {
      for (std::int64_t i = 0; i < count; ++i) put_texel(out, i, straight_texel(rows, i));
    } else if (has_coverage_) {
      for (std::int64_t i = 0; i < count; ++i) put_texel(out, i, halves(straight_texel(rows, i)));
    } else {
      for (std::int64_t i = 0; i < count; ++i)
        put_texel(out, i, halves({limited(rows.here[0][i]), limited(rows.here[1][i]), limited(rows.here[2][i]), 1.0F}));
    }
    return {};
  }

  // Light beside the data stays for bilinear lookups where coverage can say that it is none; otherwise there
  // is none, but for blocks, whose two ends would have to reach from the light to the darkness beside it.
  void mark_outside(std::size_t, std::byte* texels, std::int64_t count) const override {
    const auto bytes = static_cast<std::int64_t>(format_info(texels_).block_bytes);
    if (parts_[0].format == TexelFormat::kBc6h) return;
    if (!has_coverage_) {
      std::memset(texels, 0, static_cast<std::size_t>(count * bytes));
      return;
    }
    const std::int64_t coverage_bytes = bytes / 4;
    for (std::int64_t i = 1; i <= count; ++i) std::memset(texels + i * bytes - coverage_bytes, 0, static_cast<std::size_t>(coverage_bytes));
  }

  void add_errors(std::size_t, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    const auto step = static_cast<std::int64_t>(parts_[0].components.size());
    for (std::int64_t i = 0; i < count; ++i) {
      const double weight = reference[kWeight][i];
      if (weight <= 0.0) continue;
      const double coverage = has_coverage_ ? static_cast<double>(stored[i * step + 3]) : 1.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double total = reference[c][i];
        const double wanted = has_coverage_ ? total / weight : total;
        const double is = stored_scale_ * static_cast<double>(stored[i * step + static_cast<std::int64_t>(c)]);
        errors[0].add(is - wanted);
        errors[0].add_total(total, is * coverage);
        errors[1].add(std::max(0.0, wanted - stored_scale_ * static_cast<double>(limit_)));
      }
    }
  }

  void count_losses(const ConstPlaneRow& row, bool, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    if (losses_.empty()) return;
    for (std::int64_t i = 0; i < count; ++i) {
      const float weight = row[kWeight][i];
      if (!(weight > 0.0F)) {
        if (!has_coverage_) counts[kVoid].add(x + i, y);
        continue;
      }
      const float brightest = std::max({row[0][i], row[1][i], row[2][i]}) * per_scale_ / (has_coverage_ ? weight : 1.0F);
      if (brightest > limit_) counts[kTooBright].add(x + i, y);
      if (brightest > 0.0F && brightest <= kLeastStored) counts[kTooDim].add(x + i, y);
    }
  }

 private:
  enum LossNumber : std::size_t { kTooBright, kTooDim, kVoid };

  void describe_losses(TexelFormat format, const std::string& unit) {
    if (format == TexelFormat::kRgba32Float) return;
    const std::string name(format_info(format).name);
    const auto light_text = [&](double number) { return text::number_text(stored_scale_ * number, 6) + (unit.empty() ? "" : " " + unit); };
    losses_.push_back({"the light is more than " + light_text(static_cast<double>(limit_)) + ", the most that " + name +
                       " holds in this layer, and that is stored; give a larger `stored-scale`, or use rgba32f"});
    losses_.push_back({"there is light, but less than " + light_text(static_cast<double>(kLeastStored)) + ", of which " + name +
                       " stores nothing in this layer; give a smaller `stored-scale`, or use rgba32f"});
    if (!has_coverage_)
      losses_.push_back({"there are no data, which " + name + " cannot say, and darkness is stored; to keep them apart use rgba16f"});
  }

  // What is stored of light.
  [[nodiscard]] float limited(float light) const { return std::min(light * per_scale_, limit_); }

  static std::array<std::uint16_t, 4> halves(const std::array<float, 4>& texel) {
    return {half_from_float(texel[0]), half_from_float(texel[1]), half_from_float(texel[2]), half_from_float(texel[3])};
  }

  // Light as it is, and coverage. A texel without data has the mean light of its neighbours.
  [[nodiscard]] std::array<float, 4> straight_texel(const RowNeighbourhood& rows, std::int64_t i) const {
    const float weight = rows.opaque ? 1.0F : rows.here[kWeight][i];
    if (weight == 1.0F) return {limited(rows.here[0][i]), limited(rows.here[1][i]), limited(rows.here[2][i]), 1.0F};
    if (weight > 0.0F)
      return {limited(rows.here[0][i] / weight), limited(rows.here[1][i] / weight), limited(rows.here[2][i] / weight), weight};
    const std::array<double, 4> sum = sum_around<double>(rows, kThreeAndWeight, i);
    std::array<float, 4> texel{};
    if (sum[kWeight] > 0.0)
      for (std::size_t p = 0; p < 3; ++p) texel[p] = limited(static_cast<float>(sum[p] / sum[kWeight]));
    return texel;
  }

  template <class T>
  bool decode_codes(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const int bands = layout_.value_bands;
    const auto step = static_cast<std::size_t>(bands + (layout_.has_alpha ? 1 : 0));
    const double full = layout_.full_alpha();
    const std::size_t green = bands == 1 ? 0 : 1;
    const std::size_t blue = bands == 1 ? 0 : 2;
    bool opaque = true;
    std::array<T, 4> code{};
    for (std::int64_t i = 0; i < count; ++i, samples += step * sizeof(T)) {
      std::memcpy(code.data(), samples, step * sizeof(T));
      float weight = layout_.has_alpha ? static_cast<float>(std::min(code[step - 1] / full, 1.0)) : 1.0F;
      if (nodata_[0].contains(code[0]) && nodata_[green].contains(code[green]) && nodata_[blue].contains(code[blue])) weight = 0.0F;
      opaque = opaque && weight == 1.0F;
      out[0][i] = weight * light_of_code_[code[0]];
      out[1][i] = weight * light_of_code_[code[green]];
      out[2][i] = weight * light_of_code_[code[blue]];
      out[kWeight][i] = weight;
    }
    return opaque;
  }

  // Linear light as floats, with no nodata and no coverage to look at.
  bool decode_floats(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const auto bands = static_cast<std::size_t>(layout_.value_bands);
    const std::size_t green = bands == 1 ? 0 : 1;
    const std::size_t blue = bands == 1 ? 0 : 2;
    std::array<float, 3> value{};
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i, samples += bands * sizeof(float)) {
      std::memcpy(value.data(), samples, bands * sizeof(float));
      const bool finite = std::isfinite(value[0]) && std::isfinite(value[green]) && std::isfinite(value[blue]);
      opaque = opaque && finite;
      out[0][i] = finite ? light_of(value[0]) : 0.0F;
      out[1][i] = finite ? light_of(value[green]) : 0.0F;
      out[2][i] = finite ? light_of(value[blue]) : 0.0F;
      out[kWeight][i] = finite ? 1.0F : 0.0F;
    }
    return opaque;
  }

  bool decode_any(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const std::size_t bytes = sample_bytes(layout_.type);
    const double full = layout_.full_alpha();
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      std::array<double, 3> value{};
      bool all_nodata = true;
      bool finite = true;
      for (std::size_t b = 0; b < static_cast<std::size_t>(layout_.value_bands); ++b, samples += bytes) {
        value[b] = read_sample(layout_.type, samples);
        finite = finite && std::isfinite(value[b]);
        all_nodata = all_nodata && nodata_[b].contains(value[b]);
      }
      float weight = 1.0F;
      if (layout_.has_alpha) {
        const double coverage = read_sample(layout_.type, samples) / full;
        finite = finite && std::isfinite(coverage);
        weight = static_cast<float>(std::clamp(coverage, 0.0, 1.0));
        samples += bytes;
      }
      if (all_nodata || !finite) weight = 0.0F;
      opaque = opaque && weight == 1.0F;
      for (std::size_t b = 0; b < 3; ++b) out[b][i] = weight > 0.0F ? weight * light_of(value[layout_.value_bands == 1 ? 0 : b]) : 0.0F;
      out[kWeight][i] = weight;
    }
    return opaque;
  }

  // The light of a number that is no code. Light that no float can hold becomes the largest one.
  [[nodiscard]] float light_of(double value) const {
    const double light = std::max(0.0, value * scale_);
    return static_cast<float>(std::min(light, static_cast<double>(std::numeric_limits<float>::max())));
  }

  SampleLayout layout_;
  std::array<NodataRange, 3> nodata_;  // of the value bands
  TexelFormat texels_;
  double scale_;
  double stored_scale_;
  float per_scale_;
  float limit_;  // of the stored number
  bool has_coverage_ = false;
  std::vector<float> light_of_code_;
};

constexpr std::array kFormats{TexelFormat::kRgba32Float, TexelFormat::kRgba16Float, TexelFormat::kRgb9e5, TexelFormat::kBc6h};

MadeCodec make_illumination(const ChannelSettings& settings, const SampleLayout& layout) {
  if (layout.value_bands != 1 && layout.value_bands != 3)
    return fail(ErrorCode::kUnsupported, "illumination needs one band or three, found " + std::to_string(layout.value_bands) +
                                             "; choose with `bands`, for example `bands` 1");
  if (layout.range)
    return fail(ErrorCode::kUnsupported,
                "illumination has no black and white to be given as a range; say how much light it is with `scale`");
  constexpr std::array<std::string_view, 2> kTransfers{"linear", "srgb"};
  Light light;
  VT_ASSIGN(const std::string transfer, choice_of(settings.options, "transfer", "linear", kTransfers));
  light.transfer = transfer == "srgb" ? Transfer::kSrgb : Transfer::kLinear;
  if (light.transfer == Transfer::kSrgb && !is_code(layout.type))
    return fail(ErrorCode::kUnsupported, std::string("srgb is a transfer of 8 and 16 bit codes; ") + sample_name(layout.type) +
                                             " samples are light: leave `transfer` out");
  VT_ASSIGN(const auto scale, number_of(settings.options, "scale", std::numeric_limits<float>::min(), std::numeric_limits<float>::max()));
  light.scale = scale.value_or(1.0);
  constexpr double kLeastScale = 0x1p-60;
  VT_ASSIGN(const auto stored_scale, number_of(settings.options, "stored-scale", kLeastScale, 1.0 / kLeastScale));
  light.stored_scale = stored_scale.value_or(settings.stored_light);
  // Codes are only a share of the full one until somebody says what that is.
  const bool is_relative = is_code(layout.type) && !scale;
  const auto unit = settings.options.find("unit");
  light.unit = unit != settings.options.end() ? unit->second : is_relative ? "" : std::string(kRadianceUnit);
  return std::make_unique<const IlluminationCodec>(layout, light, settings.format);
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"transfer", "linear|srgb", "what the codes of 8 and 16 bit input are proportional to (default: linear)"},
    {"scale", "LIGHT", "light of the full code of 8 and 16 bit input, of the number 1 of other input (default: 1)"},
    {"stored-scale", "LIGHT",
     "light of the number 1 in the store, of which readers multiply what is stored; powers of two round nothing (default: 1, or less where "
     "light of numbers as small as the first build finds them would be lost in rgba16f, rgb9e5 or bc6h)"},
    {"unit", "TEXT", "unit of the light (default: W/(m2 sr), or none for codes without a scale)"},
});

}  // namespace

constinit const ChannelKind kIlluminationKind{
    .type = ChannelType::kIllumination,
    .name = "illumination",
    .unit = kRadianceUnit,
    .options = kOptions,
    .bands_wanted = [](int candidates) { return candidates >= 3 ? 3 : 1; },
    .reads_colors = true,
    .concern = source::Concern::kColor,
    .why_only_box = "light has to be conserved and cannot be negative",
    .formats = always_formats<kFormats>,
    .why_not_format = [](TexelFormat, const Options&) { return std::string_view(", which has no room for lamps beside darkness"); },
    .usual_format = [](SampleType, bool) { return TexelFormat::kRgba32Float; },
    .fourth_is_coverage = true,
    .chooses_stored_light = [](TexelFormat format,
                               const Options& options) { return format != TexelFormat::kRgba32Float && !options.contains("stored-scale"); },
    .shown = Shown::kLight,
    .absent = Absent::kZero,
    .make = make_illumination,
};

}  // namespace vt::channels
