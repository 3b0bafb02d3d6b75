// Aspects: a ninth channel, written outside the builder as a program would that has numbers of its own. A
// number is the direction in which a slope looks, in degrees clockwise from north; directions of 359 and 1
// average to 0, so what averages is the vector. Planes: north and east times weight, then the weight. Stored
// are the mean's north and east as codes of rg16.

#include <array>
#include <cmath>
#include <numbers>

#include "builder/channels/all_channels.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/shared/unorm_code.h"

namespace vt::channels {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr ChannelType kAspect{kFirstPrivateChannel + 1};

class AspectCodec final : public ChannelCodec {
 public:
  explicit AspectCodec(const SampleLayout& layout) : layout_(weighed_by_coverage(layout)), nodata_(nodata_range(layout)) {
    source_planes_ = 3;
    rules_.assign(3, PlaneRule::kLinear);
    Part directions{.format = TexelFormat::kRg16, .texel_format = TexelFormat::kRg16, .components = {"north", "east"}};
    directions.ranges = {code_.range, code_.range};
    directions.zero_is_nodata = true;
    parts_ = {directions};
    measures_.push_back({.name = "direction", .unit = "deg"});
    keeps_numbers_ = false;
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i, samples += sample_bytes(layout_.type)) {
      const double degrees = read_sample(layout_.type, samples);
      const bool is_there = std::isfinite(degrees) && !nodata_.contains(degrees);
      opaque = opaque && is_there;
      out[0][i] = is_there ? static_cast<float>(std::cos(degrees * kDegree)) : 0.0F;
      out[1][i] = is_there ? static_cast<float>(std::sin(degrees * kDegree)) : 0.0F;
      out[2][i] = is_there ? 1.0F : 0.0F;
    }
    return opaque;
  }

  Result<void> encode_row(std::size_t, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    for (std::int64_t i = 0; i < count; ++i) {
      std::array<std::uint16_t, 2> codes{0, 0};
      const float weight = rows.here[2][i];
      for (std::size_t c = 0; weight > 0.0F && c < 2; ++c) codes[c] = code_.code(rows.here[c][i] / weight);
      std::memcpy(out + i * std::int64_t{sizeof codes}, codes.data(), sizeof codes);
    }
    return {};
  }

  void mark_outside(std::size_t, std::byte* texels, std::int64_t count) const override {
    std::fill_n(texels, static_cast<std::size_t>(count) * format_info(TexelFormat::kRg16).block_bytes, std::byte{0});
  }

  void add_errors(std::size_t, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    for (std::int64_t i = 0; i < count; ++i) {
      if (!(reference[2][i] > 0.0F)) continue;
      const double wanted = std::atan2(reference[1][i], reference[0][i]);
      const double is = std::atan2(code_.value(stored[2 * i + 1]), code_.value(stored[2 * i]));
      errors[0].add(std::abs(std::remainder(is - wanted, 2.0 * std::numbers::pi)) / kDegree);
    }
  }

 private:
  SampleLayout layout_;
  NodataRange nodata_;
  UnormCode code_ = unorm_code(TexelFormat::kRg16, -1.0, 1.0, 1);
};

constexpr std::array kFormats{TexelFormat::kRg16};

MadeCodec make_aspect(const ChannelSettings&, const SampleLayout& layout) { return std::make_unique<const AspectCodec>(layout); }

constinit const ChannelKind kAspectKind{
    .type = kAspect,
    .name = "aspect",
    .has_one_value = true,
    .why_only_box = "the mean of directions has a length only if none is subtracted",
    .formats = always_formats<kFormats>,
    .usual_format = [](SampleType, bool) { return TexelFormat::kRg16; },
    .make = make_aspect,
};

const ExtraChannel kExtra(kAspectKind);

}  // namespace
}  // namespace vt::channels
