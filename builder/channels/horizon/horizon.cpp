// Horizons. A number is the angle above the level, in radians, below which the terrain hides the sky in one
// direction. No single angle stands for the texels under a coarse one: what averages exactly is the angle and
// its square, from which mean and standard deviation are stored. The share of the surface that the sun
// reaches is then lit_fraction() of the two. Directions never mix.
//
// Planes: for each direction the angle times weight; the weight; for each direction the square of the angle
// times weight (before the weight where the source brings deviations, since then it is averaged by resampling
// as well). Sums are floats: a deviation is lost in their rounding below about 0.0003 of the angle.
//
// Codes. Means are spread evenly over `span` (by default all from -90 to 90 degrees: 0.0027 degrees a step in
// 16 bits, 0.71 in 8) and clamped to it, deviations over 0 to half the span, no more than 45 degrees. Code 0
// of the first mean is no data, except in bc5, which has no code to spare and shows its neighbours there.

#include "builder/channels/horizon/horizon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <string>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/horizon/horizon_input.h"
#include "builder/channels/horizon/lit_fraction.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/shared/angle.h"
#include "builder/channels/shared/format_of_channels.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/unblocked_format.h"
#include "builder/channels/shared/unorm_code.h"
#include "builder/channels/shared/unorm_rows.h"
#include "builder/text/number_text.h"

namespace vt::channels {
namespace {

struct Span {
  double low_deg = -90.0;
  double high_deg = 90.0;
};

// One direction under one texel, in radians.
struct Horizon {
  float mean = 0.0F;
  float deviation = 0.0F;
};

constexpr std::int64_t kAtOnce = 256;  // texels of a row that are encoded together

// Where the sun's reach is compared: closer where shadows are long.
constexpr std::array<double, 6> kSunElevationsDeg{1.0, 3.0, 6.0, 12.0, 20.0, 30.0};

class HorizonCodec final : public ChannelCodec {
 public:
  HorizonCodec(const HorizonInput& input, TexelFormat format, const Span& span)
      : input_(input), directions_(input.directions()), is_block_(format == TexelFormat::kBc5) {
    input_.layout = weighed_by_coverage(input.layout);
    source_planes_ = static_cast<int>(input.source_planes());
    rules_.assign(2 * directions_ + 1, PlaneRule::kLinear);
    measures_.push_back({.name = "lit fraction", .unit = ""});
    measures_.push_back({.name = "mean angle", .unit = "deg"});
    mean_ = unorm_code(format, span.low_deg * kRadiansPerDegree, span.high_deg * kRadiansPerDegree, is_block_ ? 0 : 1);
    const double most_deviation_deg = std::min(0.5 * (span.high_deg - span.low_deg), 45.0);
    deviation_ = unorm_code(format, 0.0, most_deviation_deg * kRadiansPerDegree, 0);
    const std::size_t at_once = format_info(format).channels / 2U;  // each has a mean and a deviation
    for (std::size_t first = 0; first < directions_; first += at_once) {
      const std::size_t count = std::min(at_once, directions_ - first);
      add_part(first, count, format_of_channels(format, 2 * static_cast<int>(count)));
    }
    describe_losses(span, most_deviation_deg);
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    return input_.decode_row(samples, count, out);
  }

  void derive_row(std::int64_t count, const PlaneRow& planes) const override {
    if (input_.has_deviations) return;
    const float* const weight = planes[static_cast<std::size_t>(weight_plane())];
    for (std::size_t d = 0; d < directions_; ++d) {
      const float* const angle = planes[d];
      float* const square = planes[square_plane(d)];
      for (std::int64_t i = 0; i < count; ++i)
        square[i] = weight[i] == 1.0F ? angle[i] * angle[i] : weight[i] > 0.0F ? angle[i] * angle[i] / weight[i] : 0.0F;
    }
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    if (format_info(parts_[part].texel_format).samples == SampleKind::kUnorm8) {
      encode<std::uint8_t>(part, rows, count, out);
    } else {
      encode<std::uint16_t>(part, rows, count, out);
    }
    return {};
  }

  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    if (is_block_) return;  // keeps the copy
    const std::size_t texel_bytes = format_info(parts_[part].texel_format).block_bytes;
    const std::size_t code_bytes = texel_bytes / parts_[part].components.size();
    for (std::int64_t i = 0; i < count; ++i, texels += texel_bytes) std::memset(texels, 0, code_bytes);
  }

  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    const float* const weight = reference[static_cast<std::size_t>(weight_plane())];
    const std::size_t components = parts_[part].components.size();
    for (std::int64_t i = 0; i < count; ++i, stored += components) {
      if (!(weight[i] > 0.0F)) continue;
      for (std::size_t c = 0; c < components; c += 2) {
        const Horizon wanted = horizon_at(reference, first_direction_[part] + c / 2, i);
        const double mean = mean_.value(stored[c]);
        const double deviation = deviation_.value(stored[c + 1]);
        const LitCurve is(mean, deviation);
        const LitCurve should_be(wanted.mean, wanted.deviation);
        double lit_error = 0.0;
        for (const double sun_deg : kSunElevationsDeg)
          lit_error += std::abs(is.at(sun_deg * kRadiansPerDegree) - should_be.at(sun_deg * kRadiansPerDegree));
        errors[0].add(lit_error / static_cast<double>(kSunElevationsDeg.size()));
        errors[1].add((mean - static_cast<double>(wanted.mean)) / kRadiansPerDegree);
      }
    }
  }

  void count_losses(const ConstPlaneRow& row, bool opaque, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    if (opaque && !span_loss_) return;
    const float* const weight = row[static_cast<std::size_t>(weight_plane())];
    const auto half_step = static_cast<float>(0.5 * mean_.step());
    const auto half_deviation_step = static_cast<float>(0.5 * deviation_.step());
    for (std::int64_t i = 0; i < count; ++i) {
      if (!(weight[i] > 0.0F)) {
        if (void_loss_) counts[*void_loss_].add(x + i, y);
        continue;
      }
      bool is_beyond = false;
      for (std::size_t d = 0; span_loss_ && d < directions_; ++d) {
        const Horizon horizon = horizon_at(row, d, i);
        is_beyond = is_beyond || horizon.mean < mean_.low - half_step || horizon.mean > mean_.high + half_step ||
                    horizon.deviation > deviation_.high + half_deviation_step;
      }
      if (is_beyond) counts[*span_loss_].add(x + i, y);
    }
  }

 private:
  void describe_losses(const Span& span, double most_deviation_deg) {
    const auto add = [&](std::string what) {
      losses_.push_back({std::move(what)});
      return losses_.size() - 1;
    };
    const auto degrees = [](double angle) { return nlohmann::json(angle).dump(); };
    // No angle lies beyond the zenith, and a single one does not deviate.
    if (span.low_deg > -90.0 || span.high_deg < 90.0 || input_.has_deviations)
      span_loss_ = add("a horizon lies outside " + degrees(span.low_deg) + " to " + degrees(span.high_deg) +
                       " degrees (`span`), or deviates by more than " + degrees(most_deviation_deg) +
                       ", and the nearest that can be stored is; give a wider `span`");
    if (is_block_)
      void_loss_ =
          add("there are no data, which bc5 cannot say: it shows the neighbours' horizons, or level ground where they have none; to "
              "keep them apart use rgba16 or rg16");
  }

  void add_part(std::size_t first, std::size_t count, TexelFormat format) {
    Part part{.format = format, .texel_format = unblocked_format(format), .unit = "rad", .zero_is_nodata = !is_block_};
    nlohmann::ordered_json metadata;
    for (std::size_t d = first; d < first + count; ++d) {
      const std::string name = azimuth_name(input_.azimuths_deg[d]);
      if (first > 0) part.suffix += (d > first ? "-" : "") + name;
      part.components.push_back(name + " mean");
      part.components.push_back(name + " deviation");
      part.ranges[2 * (d - first)] = mean_.range;
      part.ranges[2 * (d - first) + 1] = deviation_.range;
      metadata["azimuths_deg"].push_back(input_.azimuths_deg[d]);
    }
    part.metadata_json = metadata.dump();
    parts_.push_back(std::move(part));
    first_direction_.push_back(first);
  }

  [[nodiscard]] std::size_t square_plane(std::size_t direction) const { return directions_ + direction + (input_.has_deviations ? 0 : 1); }

  static Horizon horizon_of(float angle_sum, float square_sum, float weight) {
    const float mean = weight == 1.0F ? angle_sum : angle_sum / weight;
    const float mean_square = weight == 1.0F ? square_sum : square_sum / weight;
    const float variance = mean_square - mean * mean;
    return {mean, variance > 0.0F ? std::sqrt(variance) : 0.0F};
  }

  // The texel's weight is not 0.
  [[nodiscard]] Horizon horizon_at(const ConstPlaneRow& planes, std::size_t direction, std::int64_t i) const {
    return horizon_of(planes[direction][i], planes[square_plane(direction)][i], planes[static_cast<std::size_t>(weight_plane())][i]);
  }

  // The neighbours' horizon together; level ground where there are none.
  [[nodiscard]] Horizon borrowed_horizon(const RowNeighbourhood& rows, std::size_t direction, std::int64_t i) const {
    const std::array planes{direction, square_plane(direction), static_cast<std::size_t>(weight_plane())};
    const auto [angle, square, weight] = sum_around<float>(rows, planes, i);
    return weight > 0.0F ? horizon_of(angle, square, weight) : Horizon{};
  }

  // Pieces of a row on the stack: horizons, their codes, the texels.
  template <class Code>
  void encode(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const {
    const float* const weight = rows.here[static_cast<std::size_t>(weight_plane())];
    const std::size_t components = parts_[part].components.size();
    std::array<float, kAtOnce> mean;
    std::array<float, kAtOnce> deviation;
    std::array<std::uint16_t, kAtOnce> mean_codes;
    std::array<std::uint16_t, kAtOnce> deviation_codes;
    std::array<Code, 4 * kAtOnce> texels;
    for (std::int64_t first = 0; first < count; first += kAtOnce) {
      const auto piece = static_cast<std::size_t>(std::min<std::int64_t>(kAtOnce, count - first));
      for (std::size_t c = 0; c < components; c += 2) {
        const std::size_t direction = first_direction_[part] + c / 2;
        for (std::size_t i = 0; i < piece; ++i) {
          const std::int64_t x = first + static_cast<std::int64_t>(i);
          const bool has_data = rows.opaque || weight[x] > 0.0F;
          const Horizon horizon = has_data ? horizon_at(rows.here, direction, x) : borrowed_horizon(rows, direction, x);
          mean[i] = horizon.mean;
          deviation[i] = horizon.deviation;
        }
        unorm_codes(mean_, piece, mean.data(), mean_codes.data());
        unorm_codes(deviation_, piece, deviation.data(), deviation_codes.data());
        for (std::size_t i = 0; i < piece; ++i) {
          texels[i * components + c] = static_cast<Code>(mean_codes[i]);
          texels[i * components + c + 1] = static_cast<Code>(deviation_codes[i]);
        }
      }
      if (!rows.opaque && !is_block_)
        for (std::size_t i = 0; i < piece; ++i)
          if (!(weight[first + static_cast<std::int64_t>(i)] > 0.0F)) texels[i * components] = 0;
      std::memcpy(out, texels.data(), piece * components * sizeof(Code));
      out += piece * components * sizeof(Code);
    }
  }

  HorizonInput input_;
  std::size_t directions_;
  bool is_block_;
  UnormCode mean_;
  UnormCode deviation_;
  std::vector<std::size_t> first_direction_;  // of each part
  // Among losses(), where there are such.
  std::optional<std::size_t> span_loss_;
  std::optional<std::size_t> void_loss_;
};

Result<Span> choose_span(const Options& options) {
  VT_ASSIGN(const std::vector<double> numbers, numbers_of(options, "span"));
  if (numbers.empty()) return Span{};
  if (numbers.size() != 2 || numbers[0] < -90.0 || numbers[1] > 90.0 || !(numbers[0] + 1.0 <= numbers[1]))
    return fail(ErrorCode::kUsage, "option span: LOW,HIGH are two angles from -90 to 90 degrees, HIGH at least one degree above LOW");
  return Span{numbers[0], numbers[1]};
}

constexpr std::array kFormats{TexelFormat::kRgba16, TexelFormat::kRg16, TexelFormat::kRgba8, TexelFormat::kRg8, TexelFormat::kBc5};

std::string_view why_not_format(TexelFormat format, const Options&) {
  return is_color_block(format_info(format)) ? ": its blocks tie angles and deviations together, which moves shadows" : "";
}

MadeCodec make_horizon(const ChannelSettings& settings, const SampleLayout& layout) {
  VT_ASSIGN(const Span span, choose_span(settings.options));
  VT_ASSIGN(const HorizonInput input, choose_horizon_input(settings.options, layout));
  return std::make_unique<const HorizonCodec>(input, settings.format, span);
}

// The largest size of a number that is beyond a right angle in radians, and none in degrees; 0: there is
// none.
template <class T>
double largest_degrees(const SampleLayout& layout, std::span<const std::byte> samples) {
  constexpr double kMostRadians = std::numbers::pi / 2.0 * 1.001;
  constexpr double kMostDegrees = 90.001;
  const auto bands = static_cast<std::size_t>(layout.value_bands);
  double largest = 0.0;
  for (std::size_t band = 0; band < bands; ++band) {
    const auto nodata = typed_nodata_range<T>(layout, band);
    for (std::size_t at = band * sizeof(T); at + sizeof(T) <= samples.size(); at += layout.texel_bytes()) {
      T number;
      std::memcpy(&number, samples.data() + at, sizeof number);
      const double size = std::abs(layout.offset.value_or(0.0) + layout.scale.value_or(1.0) * static_cast<double>(number));
      if (size > kMostRadians && size <= kMostDegrees && !nodata.contains(number)) largest = std::max(largest, size);
    }
  }
  return largest;
}

// Numbers of which neither the file nor the user says a unit are taken as radians. Those that are no such
// angles would leave texels without data, so what looks like degrees is refused.
Result<void> check_unit(const Options& options, const SampleLayout& layout, std::span<const std::byte> samples) {
  const bool is_float = layout.type == SampleType::kFloat32 || layout.type == SampleType::kFloat64;
  if (options.contains("angles") || !layout.unit.empty() || !is_float) return {};
  const double largest =
      layout.type == SampleType::kFloat32 ? largest_degrees<float>(layout, samples) : largest_degrees<double>(layout, samples);
  if (largest == 0.0) return {};
  return fail(ErrorCode::kInvalidData, "holds angles up to " + text::number_text(largest) +
                                           ", more than any horizon has in radians; say `angles` deg, or `angles` rad if what is beyond "
                                           "a right angle means no data");
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"azimuths", "DEGREES,...", "direction of each band, clockwise from north (default: 90,270 of two, evenly from north of more)"},
    {"angles", "rad|deg", "unit of the input's angles (default: the one that the file declares, else rad)"},
    {"deviations", "none|given", "whether bands are single angles, or pairs of mean and standard deviation (default: none)"},
    {"span", "LOW,HIGH",
     "degrees that codes are spread over; fewer give low sun finer steps, horizons beyond are clamped (default: -90,90)"},
});

}  // namespace

constinit const ChannelKind kHorizonKind{
    .type = ChannelType::kHorizon,
    .name = "horizon",
    .unit = "rad",
    .options = kOptions,
    .bands_wanted = [](int candidates) { return candidates; },
    .uses_declared_scale = true,
    .check_samples = check_unit,
    .why_only_box = "what is averaged are moments of a distribution of angles, and a negative share of a distribution does not exist",
    .formats = always_formats<kFormats>,
    .why_not_format = why_not_format,
    .usual_format = [](SampleType, bool) { return TexelFormat::kRgba16; },
    .make = make_horizon,
};

}  // namespace vt::channels
