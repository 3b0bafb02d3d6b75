// Masks. A number is the share of a texel that lies inside, 0 to 1; shares average as they are, over the
// samples that exist. Planes: share in 255ths (so that means of bytes are exact) times weight, weight (1
// data, 0 none). Where nothing is known nothing is inside: such a texel is stored as 0 and counts in no mean.
//
// For alpha tests ("inside is what exceeds REF") the plain mean is kept as the part "mean", and the layer's
// coarser levels are made of it after the blocks, see builder/pipeline/passes/coverage_pass.h.

#include "builder/channels/mask/mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/shared/unblocked_format.h"

namespace vt::channels {
namespace {

class MaskCodec final : public ChannelCodec {
 public:
  // `inside`: source values that count as inside, all others are outside; empty: samples are shares.
  MaskCodec(const SampleLayout& layout, TexelFormat format, std::vector<double> inside, std::optional<double> kept_above)
      : layout_(layout), inside_(std::move(inside)) {
    if (layout.type == SampleType::kFloat32)
      for (double& value : inside_) value = static_cast<double>(static_cast<float>(value));
    source_planes_ = 2;
    rules_.assign(2, PlaneRule::kLinear);
    Part shares{.format = format, .texel_format = unblocked_format(format), .components = {"coverage"}};
    // The decoded scale of blocks is that of bytes, whatever their encoder takes.
    shares.ranges[0].scale = format == TexelFormat::kR16 ? 1.0 / 65535.0 : 1.0 / 255.0;
    if (kept_above) {
      kept_above_ = kept_above;
      shares.ends_at_base = true;
      Part mean{.suffix = "mean", .format = TexelFormat::kR16, .texel_format = TexelFormat::kR16, .components = {"mean coverage"}};
      mean.ranges[0].scale = 1.0 / 65535.0;
      mean.starts_above_base = true;
      parts_ = {shares, mean};
    } else {
      parts_ = {shares};
    }
    measures_.push_back({.name = "coverage", .unit = ""});
    losses_.push_back({"there are no data, which a mask cannot say: what is stored is 0, as of what is outside"});
    if (layout.type == SampleType::kUint8 && inside_.empty() && !layout.range && layout.full_value() == kWhole)
      for (std::size_t code = 0; code < share_of_code_.size(); ++code) share_of_code_[code] = static_cast<float>(code);
    else if (layout.type == SampleType::kUint8)
      for (std::size_t code = 0; code < share_of_code_.size(); ++code) share_of_code_[code] = share_of(static_cast<double>(code));
    samples_are_texels_ = layout.type == SampleType::kUint8 && format == TexelFormat::kR8 && inside_.empty() && !layout.range &&
                          layout.full_value() == kWhole && !layout.nodata && !layout.has_alpha;
    nodata_ = nodata_range(layout);
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    float* const share = out[0];
    float* const weight = out[1];
    if (layout_.type == SampleType::kUint8 && !layout_.has_alpha && !layout_.nodata) {
      const auto* codes = reinterpret_cast<const std::uint8_t*>(samples);
      for (std::int64_t i = 0; i < count; ++i) share[i] = share_of_code_[codes[i]];
      std::fill_n(weight, count, 1.0F);
      return true;
    }
    const std::size_t bytes = sample_bytes(layout_.type);
    const double alpha_full = layout_.full_alpha();
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      const double value = read_sample(layout_.type, samples);
      samples += bytes;
      float w = 1.0F;
      if (layout_.has_alpha) {
        const double alpha = read_sample(layout_.type, samples) / alpha_full;
        w = std::isfinite(alpha) ? static_cast<float>(std::clamp(alpha, 0.0, 1.0)) : 0.0F;
        samples += bytes;
      }
      if (!std::isfinite(value) || nodata_.contains(value)) w = 0.0F;
      opaque = opaque && w == 1.0F;
      weight[i] = w;
      share[i] = w > 0.0F ? w * share_of(value) : 0.0F;
    }
    return opaque;
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    const float* const share = rows.here[0];
    const float* const weight = rows.here[1];
    if (parts_[part].texel_format == TexelFormat::kR8) {
      encode<std::uint8_t>(share, weight, rows.opaque, count, out);
    } else {
      encode<std::uint16_t>(share, weight, rows.opaque, count, out);
    }
    return {};
  }

  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    std::fill_n(texels, static_cast<std::size_t>(count) * format_info(parts_[part].texel_format).block_bytes, std::byte{0});
  }

  void count_losses(const ConstPlaneRow& row, bool opaque, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    for (std::int64_t i = 0; !opaque && i < count; ++i)
      if (!(row[1][i] > 0.0F)) counts[0].add(x + i, y);
  }

  // Errors are those of the layer itself; its levels that are not means are never asked for.
  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    if (part != 0) return;
    for (std::int64_t i = 0; i < count; ++i) {
      if (!(reference[1][i] > 0.0F)) continue;
      const double wanted = static_cast<double>(reference[0][i]) / reference[1][i] / kWhole;
      const double is = parts_[0].ranges[0].scale * static_cast<double>(stored[i]);
      errors[0].add(is - wanted);
      errors[0].add_total(wanted, is);
    }
  }

 private:
  static constexpr double kWhole = 255.0;  // all of a texel, in planes

  [[nodiscard]] float share_of(double value) const {
    if (!inside_.empty()) {
      const bool is_inside = std::ranges::find(inside_, value) != inside_.end();
      return is_inside ? static_cast<float>(kWhole) : 0.0F;
    }
    const std::array<double, 2> range = layout_.range.value_or(std::array<double, 2>{0.0, layout_.full_value()});
    return static_cast<float>(kWhole * std::clamp((value - range[0]) / (range[1] - range[0]), 0.0, 1.0));
  }

  // Shares are in 0 to 255 but for roundings of the filter. Ties go to the even code: means of two and four
  // bytes have many, and a rounding that is always up would brighten every level by an eighth of a code.
  template <class Code>
  static void encode(const float* share, const float* weight, bool opaque, std::int64_t count, std::byte* out) {
    constexpr float kStep = static_cast<float>(std::numeric_limits<Code>::max()) / 255.0F;  // 1 or 257
    constexpr float kNoFraction = 0x1.8p23F;                                                // adding it leaves no fraction bits
    for (std::int64_t i = 0; i < count; ++i) {
      const float w = opaque ? 1.0F : weight[i];
      const float value = w == 1.0F ? share[i] : w > 0.0F ? share[i] / w : 0.0F;
      const float clamped = value < 255.0F ? value : 255.0F;
      const auto code = static_cast<Code>((clamped * kStep + kNoFraction) - kNoFraction);
      std::memcpy(out + i * std::int64_t{sizeof code}, &code, sizeof code);
    }
  }

  SampleLayout layout_;
  NodataRange nodata_;
  std::vector<double> inside_;
  std::array<float, 256> share_of_code_{};
};

constexpr std::array kFormats{TexelFormat::kR8, TexelFormat::kR16, TexelFormat::kBc4};

MadeCodec make_mask(const ChannelSettings& settings, const SampleLayout& layout) {
  const TexelFormat format = settings.format;
  if (layout.value_bands != 1)
    return fail(ErrorCode::kUnsupported, "a mask needs exactly one band, found " + std::to_string(layout.value_bands) +
                                             "; choose with `bands`, for example `bands` 4");
  VT_ASSIGN(std::vector<double> inside, numbers_of(settings.options, "inside"));
  if (!inside.empty() && layout.range)
    return fail(ErrorCode::kUsage, "values that are inside and a range of shares exclude each other; give one of `inside` and `range`");
  const bool is_share = layout.type == SampleType::kUint8 || layout.type == SampleType::kUint16 || layout.type == SampleType::kFloat32 ||
                        layout.type == SampleType::kFloat64;
  if (!is_share && inside.empty() && !layout.range)
    return fail(ErrorCode::kUnsupported, std::string("a mask from ") + sample_name(layout.type) +
                                             " samples needs to know what is inside; give `inside` VALUES, or `range` LOW,HIGH for shares");
  // Exactly 0 or 1 would mean all or nothing, whatever is stored.
  VT_ASSIGN(const std::optional<double> kept_above, number_of(settings.options, "alpha-coverage", 0.001, 0.999));
  return std::make_unique<const MaskCodec>(layout, format, std::move(inside), kept_above);
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"inside", "VALUES",
     "sample values that are inside, with commas between them; all others are outside (default: samples are shares from 0 to 1)"},
    {"alpha-coverage", "REF",
     "for alpha tests: scale every coarser level so that as much of it exceeds REF (0.001 to 0.999) as of the finest; the plain means stay "
     "as NAME/mean (default: plain means only)"},
});

}  // namespace

constinit const ChannelKind kMaskKind{
    .type = ChannelType::kMask,
    .name = "mask",
    .options = kOptions,
    .has_one_value = true,
    .may_be_coverage = true,
    .why_only_box = "coverage has to be conserved and cannot be negative",
    .formats = always_formats<kFormats>,
    .why_not_format = [](TexelFormat, const Options&) { return std::string_view(": they are one share from 0 to 1"); },
    .usual_format = [](SampleType, bool) { return TexelFormat::kR8; },
    .absent = Absent::kZero,
    .make = make_mask,
};

}  // namespace vt::channels
