// Colour. A number is a code of a transfer function, the source's own on the way in and the layer's on the
// way out; what averages is light. Planes: red, green, blue light times weight, then the weight, which is
// coverage (alpha) where the source has it and 1 or 0 for data and no data otherwise.

#include "builder/channels/color/color.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/color/color_rows.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/srgb.h"
#include "builder/channels/shared/unblocked_format.h"

namespace vt::channels {
namespace {

// Below half a step of 8-bit coverage nothing of a texel would be seen.
constexpr float kLeastSeenWeight = 0.5F / 255.0F;

class ColorCodec final : public ChannelCodec {
 public:
  // `transfer` of the texels, `source_transfer` of the samples. `is_associated`: samples are codes that were
  // multiplied by their coverage.
  ColorCodec(const SampleLayout& layout, Transfer transfer, Transfer source_transfer, bool is_associated, TexelFormat format)
      : layout_(layout),
        source_transfer_(source_transfer),
        is_associated_(is_associated),
        table_(code_table(transfer)),
        source_table_(code_table(source_transfer)) {
    source_planes_ = 4;
    rules_.assign(4, PlaneRule::kLinear);
    stores_alpha_ = unblocked_format(format) == TexelFormat::kRgba8;
    // An opaque format shows whatever has a colour: of a line one texel wide the coarsest levels cover next
    // to nothing.
    least_weight_ = stores_alpha_ ? kLeastSeenWeight : std::numeric_limits<float>::min();
    const auto channels = static_cast<std::size_t>(format_info(format).channels);
    const std::vector<std::string> names{"red", "green", "blue", "coverage"};
    parts_.push_back({.format = format,
                      .texel_format = unblocked_format(format),
                      .components = {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(channels)}});
    measures_.push_back({.name = "light", .unit = "", .is_light = true});
    if (stores_alpha_) measures_.push_back({.name = "coverage", .unit = ""});
    rules_version_ = 2;  // light once went to the nearest place on the code axis
    const bool same_channels = layout.value_bands == 3 && layout.has_alpha == stores_alpha_;
    const bool is_byte = layout.type == SampleType::kUint8 && layout.full_value() == 255.0;
    is_plain_8_bit_ = is_byte && layout.full_alpha() == 255.0 && !layout.range && !is_associated;
    samples_are_texels_ = is_plain_8_bit_ && same_channels && !(layout.has_alpha && layout.nodata) && source_transfer == transfer;
    for (std::size_t b = 0; b < nodata_.size(); ++b) nodata_[b] = nodata_range(layout, b);
    if (is_byte && std::ranges::none_of(nodata_, &NodataRange::empty))
      for (std::size_t b = 0; b < nodata_.size(); ++b) nodata_code_[b] = static_cast<int>(nodata_[b].low);
    describe_losses(format);
    const bool is_16_bit = layout.type == SampleType::kUint16;
    if (is_associated && !layout.range && (is_byte || (is_16_bit && layout.full_value() == 65535.0))) {
      // Codes that are divided by their coverage lie between those that are stored.
      light_between_codes_.resize(65536);
      for (std::size_t c = 0; c < light_between_codes_.size(); ++c)
        light_between_codes_[c] = static_cast<float>(linear_from_code(source_transfer, static_cast<double>(c) / 65535.0));
    } else if (!is_associated && !is_plain_8_bit_ && (layout.type == SampleType::kUint8 || is_16_bit)) {
      light_of_code_.resize(is_16_bit ? 65536 : 256);
      for (std::size_t c = 0; c < light_of_code_.size(); ++c) light_of_code_[c] = computed_light(static_cast<double>(c));
    }
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    if (is_plain_8_bit_) return decode_8_bit(samples, count, out);
    return decode_any(samples, count, out);
  }

  Result<void> encode_row(std::size_t, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    auto* codes = reinterpret_cast<std::uint8_t*>(out);
    const bool has_alpha = stores_alpha_;
    const std::size_t step = has_alpha ? 4 : 3;
    const float* const red = rows.here[0];
    const float* const green = rows.here[1];
    const float* const blue = rows.here[2];
    const float* const weight = rows.here[3];
    if (rows.opaque && !has_alpha) {
      rgb8_from_light(red, green, blue, static_cast<std::size_t>(count), table_, codes);
      return {};
    }
    for (std::int64_t i = 0; i < count; ++i, codes += step) {
      const float w = rows.opaque ? 1.0F : weight[i];
      if (w == 1.0F) {
        codes[0] = table_.code(red[i], i);
        codes[1] = table_.code(green[i], i);
        codes[2] = table_.code(blue[i], i);
      } else if (w >= least_weight_) {
        codes[0] = table_.code(red[i] / w, i);
        codes[1] = table_.code(green[i] / w, i);
        codes[2] = table_.code(blue[i] / w, i);
      } else {
        encode_empty(rows, i, codes);
      }
      if (has_alpha) codes[3] = alpha_code(w);
    }
    return {};
  }

  void mark_outside(std::size_t, std::byte* texels, std::int64_t count) const override {
    if (!stores_alpha_) return;  // an opaque format has nothing but the neighbour's colour to show there
    for (std::int64_t i = 0; i < count; ++i) texels[4 * i + 3] = std::byte{0};
  }

  // In light, where 1 is white, and in shares. Where coverage is stored an error of light counts by it, for
  // that is how much of it is seen; opaque formats show all of it however little of the texel had data.
  void add_errors(std::size_t, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    const std::int64_t step = static_cast<std::int64_t>(parts_[0].components.size());
    for (std::int64_t i = 0; i < count; ++i) {
      const float weight = reference[3][i];
      if (!(weight >= least_weight_)) continue;
      const double seen = stores_alpha_ ? std::min(static_cast<double>(weight), 1.0) : 1.0;
      for (std::size_t c = 0; c < 3; ++c) {
        // Sharp kernels ring below black and above white: what is cut off there is no error of a texel, but a
        // loss or a gain of light.
        const double filtered = static_cast<double>(reference[c][i]) / weight;
        const double wanted = std::clamp(filtered, 0.0, 1.0);
        const double is = table_.light(static_cast<std::uint8_t>(stored[i * step + static_cast<std::int64_t>(c)] + 0.5F));
        errors[0].add(seen * (is - wanted));
        errors[0].add_total(seen * filtered, seen * is);
      }
    }
    if (!stores_alpha_) return;
    for (std::int64_t i = 0; i < count; ++i) {
      const double wanted = std::clamp(static_cast<double>(reference[3][i]), 0.0, 1.0);
      const double is = static_cast<double>(stored[i * step + 3]) / 255.0;
      errors[1].add(is - wanted);
      errors[1].add_total(wanted, is);
    }
  }

  void count_losses(const ConstPlaneRow& row, bool opaque, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    if (opaque || losses_.empty()) return;
    for (std::int64_t i = 0; i < count; ++i)
      if (!(row[3][i] >= least_weight_)) counts[0].add(x + i, y);
  }

 private:
  void describe_losses(TexelFormat format) {
    if (stores_alpha_) return;
    const std::array<std::string, 3> codes{std::to_string(nodata_code_[0]), std::to_string(nodata_code_[1]),
                                           std::to_string(nodata_code_[2])};
    const bool is_one = codes[0] == codes[1] && codes[0] == codes[2];
    const std::string shown = nodata_code_[0] < 0 ? "the neighbours' colour, or black where they have none"
                              : is_one            ? "the sources' own code " + codes[0]
                                                  : "the sources' own codes " + codes[0] + ", " + codes[1] + ", " + codes[2];
    losses_.push_back({"there are no data, which " + std::string(format_info(format).name) + " cannot say: it shows " + shown +
                       "; to keep them apart use " + (format == TexelFormat::kBc1 ? "bc3 or bc7" : "rgba8")});
  }

  static std::uint8_t alpha_code(float weight) {
    const float clamped = weight > 0.0F ? (weight < 1.0F ? weight : 1.0F) : 0.0F;
    return static_cast<std::uint8_t>(clamped * 255.0F + 0.5F);
  }

  bool decode_8_bit(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const auto* codes = reinterpret_cast<const std::uint8_t*>(samples);
    const float* light = source_table_.light_table().data();
    float* const red = out[0];
    float* const green = out[1];
    float* const blue = out[2];
    float* const weight = out[3];
    const bool grey = layout_.value_bands == 1;
    if (!layout_.has_alpha && !layout_.nodata) {
      if (grey) {
        for (std::int64_t i = 0; i < count; ++i) red[i] = green[i] = blue[i] = light[codes[i]];
      } else {
        light_from_rgb8(codes, static_cast<std::size_t>(count), source_table_, red, green, blue);
      }
      std::fill_n(weight, count, 1.0F);
      return true;
    }

    const int bands = layout_.value_bands;
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i, codes += bands + (layout_.has_alpha ? 1 : 0)) {
      float w = layout_.has_alpha ? static_cast<float>(codes[bands]) / 255.0F : 1.0F;
      if (codes[0] == nodata_code_[0] && (grey || (codes[1] == nodata_code_[1] && codes[2] == nodata_code_[2]))) w = 0.0F;
      opaque = opaque && w == 1.0F;
      red[i] = w * light[codes[0]];
      green[i] = w * light[codes[grey ? 0 : 1]];
      blue[i] = w * light[codes[grey ? 0 : 2]];
      weight[i] = w;
    }
    return opaque;
  }

  bool decode_any(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const int bands = layout_.value_bands;
    const std::size_t bytes = sample_bytes(layout_.type);
    const double alpha_full = layout_.full_alpha();
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      std::array<double, 3> value{};
      bool all_nodata = true;
      bool finite = true;
      for (std::size_t b = 0; b < static_cast<std::size_t>(bands); ++b, samples += bytes) {
        value[b] = read_sample(layout_.type, samples);
        finite = finite && std::isfinite(value[b]);
        all_nodata = all_nodata && nodata_[b].contains(value[b]);
      }
      double w = 1.0;
      if (layout_.has_alpha) {
        w = std::clamp(read_sample(layout_.type, samples) / alpha_full, 0.0, 1.0);
        samples += bytes;
      }
      if (all_nodata || !finite || !(w > 0.0)) w = 0.0;  // a coverage that is no number is none
      opaque = opaque && w == 1.0;
      out[3][i] = static_cast<float>(w);
      for (std::size_t b = 0; b < 3; ++b) {
        // No colour is more than white: codes of a nearly clear texel are too coarse to be trusted with the
        // division.
        const double v = is_associated_ ? value[bands == 1 ? 0 : b] / w : value[bands == 1 ? 0 : b];
        out[b][i] = w > 0.0 ? static_cast<float>(w) * light_of(v) : 0.0F;
      }
    }
    return opaque;
  }

  [[nodiscard]] float light_of(double value) const {
    if (!light_of_code_.empty()) return light_of_code_[static_cast<std::size_t>(value)];
    if (light_between_codes_.empty()) return computed_light(value);
    const double code = value * (layout_.type == SampleType::kUint8 ? 257.0 : 1.0);
    return light_between_codes_[static_cast<std::size_t>(std::min(code + 0.5, 65535.0))];
  }

  [[nodiscard]] float computed_light(double value) const {
    const std::array<double, 2> range = layout_.range.value_or(std::array<double, 2>{0.0, layout_.full_value()});
    return static_cast<float>(linear_from_code(source_transfer_, std::clamp((value - range[0]) / (range[1] - range[0]), 0.0, 1.0)));
  }

  // A texel without colour of its own. The source's own nodata code if it has one, so that it is given back
  // exactly; else the mean colour of the neighbours that have some; else black.
  void encode_empty(const RowNeighbourhood& rows, std::int64_t i, std::uint8_t* codes) const {
    if (nodata_code_[0] >= 0) {
      for (std::size_t p = 0; p < 3; ++p) codes[p] = static_cast<std::uint8_t>(nodata_code_[p]);
      return;
    }
    const std::array<float, 4> sum = sum_around<float>(rows, kThreeAndWeight, i, least_weight_);
    for (std::size_t p = 0; p < 3; ++p) codes[p] = sum[3] > 0.0F ? table_.code(sum[p] / sum[3], i) : std::uint8_t{0};
  }

  SampleLayout layout_;
  Transfer source_transfer_;
  bool is_associated_;
  bool stores_alpha_ = false;
  float least_weight_ = 0.0F;                   // of texels that have a colour
  const CodeTable& table_;                      // of texels
  const CodeTable& source_table_;               // of 8-bit samples
  bool is_plain_8_bit_ = false;                 // samples are codes of 0 to 255, coverage too
  std::array<NodataRange, 3> nodata_;           // of the value bands
  std::array<int, 3> nodata_code_{-1, -1, -1};  // the same of 8-bit codes; -1 equals none
  std::vector<float> light_of_code_;            // of other codes than plain 8-bit ones
  std::vector<float> light_between_codes_;      // in 65535ths of the full code
};

constexpr std::array kFormats{TexelFormat::kRgb8, TexelFormat::kRgba8, TexelFormat::kBc1, TexelFormat::kBc3, TexelFormat::kBc7};

MadeCodec make_color(const ChannelSettings& settings, const SampleLayout& layout) {
  const TexelFormat format = settings.format;
  if (layout.value_bands != 1 && layout.value_bands != 3)
    return fail(ErrorCode::kUnsupported, "colour needs one band (grey) or three, found " + std::to_string(layout.value_bands) +
                                             "; choose with `bands`, for example `bands` 3,2,1");
  const bool codes = layout.type == SampleType::kUint8 || layout.type == SampleType::kUint16;
  if (!codes && !layout.range)
    return fail(ErrorCode::kUnsupported, std::string("colour from ") + sample_name(layout.type) +
                                             " samples needs to know which values are black and white; give `range` LOW,HIGH");
  constexpr std::array<std::string_view, 2> kTransfers{"srgb", "linear"};
  VT_ASSIGN(const std::string transfer, choice_of(settings.options, "transfer", "srgb", kTransfers));
  constexpr std::array<std::string_view, 2> kAlphas{"straight", "associated"};
  VT_ASSIGN(const std::string alpha, choice_of(settings.options, "alpha", "straight", kAlphas));
  const bool is_associated = alpha == "associated";
  if (is_associated && !layout.has_alpha)
    return fail(ErrorCode::kUsage,
                "colour can only be multiplied by a coverage that is there, and no band is declared as one; leave `alpha` out");
  if (is_associated && layout.range && (*layout.range)[0] != 0.0)
    return fail(ErrorCode::kUsage, "colour that is multiplied by its coverage has its black at 0; give `range` 0,HIGH");
  const Transfer source_transfer = transfer == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  return std::make_unique<const ColorCodec>(layout, settings.transfer, source_transfer, is_associated, format);
}

// Measured of aerial and satellite photographs, whose coverage costs nothing, and of their BC1 blocks.
double stored_ratio(TexelFormat format) {
  if (format == TexelFormat::kRgb8) return 0.40;
  if (format == TexelFormat::kRgba8) return 0.30;
  if (format == TexelFormat::kBc1) return 0.70;
  return kUnmeasuredRatio;
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"alpha", "straight|associated",
     "whether the input's codes are multiplied by their coverage although the file does not say so; files that declare it are understood "
     "without this (default: straight)"},
    {"transfer", "srgb|linear", "what the input's codes mean; the layer's are sRGB in any case (default: srgb)"},
    {"anti-ringing", "yes|no", "keep overshoot beside edges within the neighbouring texels (default: no)"},
});

}  // namespace

constinit const ChannelKind kColorKind{
    .type = ChannelType::kColor,
    .name = "color",
    .options = kOptions,
    .bands_wanted = [](int candidates) { return candidates >= 3 ? 3 : 1; },
    .reads_colors = true,
    .has_black_and_white = true,
    .concern = source::Concern::kColor,
    .usual_kernel = "kaiser3",
    .formats = always_formats<kFormats>,
    // Coverage has to be stored when there can be texels without data; an opaque format is the user's
    // explicit wish.
    .usual_format = [](SampleType, bool may_be_empty) { return may_be_empty ? TexelFormat::kRgba8 : TexelFormat::kRgb8; },
    .transfer = Transfer::kSrgb,
    .fourth_is_coverage = true,
    .stored_ratio = stored_ratio,
    .make = make_color,
};

}  // namespace vt::channels
