// Elevation. A number is a height in metres; heights average as they are, over the samples that exist: a void must not pull the surface
// down. Planes: height times weight, weight (1 data, 0 void). A texel without any data is stored as quiet NaN, never as a height.

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "builder/channels/channel_makers.h"
#include "builder/channels/read_samples.h"

namespace vt::channels {
namespace {

class ElevationCodec final : public ChannelCodec {
 public:
  explicit ElevationCodec(const SampleLayout& layout) : layout_(layout) {
    source_planes_ = 2;
    rules_.assign(2, PlaneRule::kLinear);
    parts_.push_back({.format = TexelFormat::kR32Float, .texel_format = TexelFormat::kR32Float, .components = {"height"}, .unit = "m"});
    measures_.push_back({.name = "height", .unit = "m"});
  }

  bool decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    switch (layout_.type) {
      case SampleType::kFloat32:
        return decode<float>(samples, count, out);
      case SampleType::kInt16:
        return decode<std::int16_t>(samples, count, out);
      case SampleType::kUint16:
        return decode<std::uint16_t>(samples, count, out);
      case SampleType::kUint8:
        return decode<std::uint8_t>(samples, count, out);
      case SampleType::kInt8:
        return decode<std::int8_t>(samples, count, out);
      case SampleType::kUint32:
        return decode<std::uint32_t>(samples, count, out);
      case SampleType::kInt32:
        return decode<std::int32_t>(samples, count, out);
      case SampleType::kFloat64:
        return decode<double>(samples, count, out);
    }
    return false;
  }

  void encode_row(std::size_t, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    const float* height = rows.here[0];
    const float* weight = rows.here[1];
    if (rows.opaque) {
      std::memcpy(out, height, static_cast<std::size_t>(count) * sizeof(float));
      return;
    }
    for (std::int64_t i = 0; i < count; ++i) {
      const float texel =
          weight[i] > 0.0F ? (weight[i] == 1.0F ? height[i] : height[i] / weight[i]) : std::numeric_limits<float>::quiet_NaN();
      std::memcpy(out + i * static_cast<std::int64_t>(sizeof texel), &texel, sizeof texel);
    }
  }

  void mark_outside(std::size_t, std::byte* texels, std::int64_t count) const override {
    const float hole = std::numeric_limits<float>::quiet_NaN();
    for (std::int64_t i = 0; i < count; ++i) std::memcpy(texels + i * static_cast<std::int64_t>(sizeof hole), &hole, sizeof hole);
  }

  void add_errors(std::size_t, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    for (std::int64_t i = 0; i < count; ++i)
      if (reference[1][i] > 0.0F) errors[0].add(static_cast<double>(stored[i]) - static_cast<double>(reference[0][i]) / reference[1][i]);
  }

 private:
  template <class T>
  bool decode(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const double nodata = layout_.nodata.value_or(std::numeric_limits<double>::quiet_NaN());
    // As the sample type sees it: a nodata that the type cannot hold equals no sample.
    const T nodata_sample = in_range<T>(nodata) ? static_cast<T>(nodata) : T{};
    const bool has_nodata = layout_.nodata && in_range<T>(nodata);
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      T sample;
      std::memcpy(&sample, samples + i * static_cast<std::int64_t>(sizeof sample), sizeof sample);
      bool is_void = has_nodata && sample == nodata_sample;
      if constexpr (std::is_floating_point_v<T>) is_void = is_void || !std::isfinite(static_cast<float>(sample));
      out[0][i] = is_void ? 0.0F : static_cast<float>(sample);
      out[1][i] = is_void ? 0.0F : 1.0F;
      opaque = opaque && !is_void;
    }
    return opaque;
  }

  template <class T>
  static bool in_range(double value) {
    if constexpr (std::is_floating_point_v<T>)
      return std::isfinite(value) && std::abs(value) <= static_cast<double>(std::numeric_limits<T>::max());
    return value == std::floor(value) && value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
           value <= static_cast<double>(std::numeric_limits<T>::max());
  }

  SampleLayout layout_;
};

}  // namespace

MadeCodec make_elevation_codec(const ChannelSettings& settings, const SampleLayout& layout) {
  if (settings.format != TexelFormat::kR32Float)
    return fail(ErrorCode::kUnsupported,
                "an elevation layer cannot be stored as " + std::string(format_info(settings.format).name) + "; use r32f");
  if (layout.value_bands != 1 || layout.has_alpha)
    return fail(ErrorCode::kUnsupported, "elevation needs exactly one band, found " +
                                             std::to_string(layout.value_bands + (layout.has_alpha ? 1 : 0)) + "; choose with --bands");
  return std::make_unique<const ElevationCodec>(layout);
}

}  // namespace vt::channels
