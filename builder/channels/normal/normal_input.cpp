#include "builder/channels/normal/normal_input.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/normal/normal_rows.h"
#include "builder/channels/samples/nodata.h"

namespace vt::channels {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// component = (sample - middle) * gain, not below -1 for integers.
struct Mapping {
  float middle = 0.0F;
  float gain = 1.0F;
  float least = 1e-30F;  // a vector with no component as large has no direction
};

template <class T>
Mapping mapping_of(bool centre_is_code, double full_scale) {
  if constexpr (std::is_floating_point_v<T>) return {};
  const auto greatest = static_cast<float>(full_scale);
  if constexpr (std::is_signed_v<T>) return {0.0F, 1.0F / greatest, 0.75F / greatest};
  const float middle = centre_is_code ? 0.5F * (greatest + 1.0F) : 0.5F * greatest;
  return {middle, 1.0F / (greatest - middle), 0.75F / (greatest - middle)};
}

template <class T>
void read_components(const NormalInput& input, const Mapping& mapping, const std::byte* samples, std::int64_t count, const PlaneRow& out) {
  const bool has_z = input.layout.value_bands == 3;
  const float y_sign = input.y_is_down ? -1.0F : 1.0F;
  const auto component = [&](T sample) {
    if constexpr (std::is_floating_point_v<T>) return static_cast<float>(sample);
    const float value = (static_cast<float>(sample) - mapping.middle) * mapping.gain;
    return value > -1.0F ? value : -1.0F;
  };
  std::array<TypedNodataRange<T>, 3> nodata;
  for (std::size_t b = 0; b < nodata.size(); ++b) nodata[b] = typed_nodata_range<T>(input.layout, b);
  const std::size_t texel_bytes = sizeof(T) * (has_z ? 3 : 2);
  std::array<T, 3> texel{};
  for (std::int64_t i = 0; i < count; ++i, samples += texel_bytes) {
    std::memcpy(texel.data(), samples, texel_bytes);
    const float x = component(texel[0]);
    const float y = component(texel[1]);
    out[0][i] = x;
    out[1][i] = y_sign * y;
    // Beyond the unit circle the root of less than nothing is taken as 0: the rim of the hemisphere.
    out[2][i] = has_z ? component(texel[2]) : std::sqrt(std::max(0.0F, 1.0F - (x * x + y * y)));
    if (nodata[0].contains(texel[0]) && nodata[1].contains(texel[1]) && (!has_z || nodata[2].contains(texel[2]))) out[0][i] = kNaN;
  }
}

template <class T>
bool decode(const NormalInput& input, const std::byte* samples, std::int64_t count, const PlaneRow& out) {
  const Mapping mapping = mapping_of<T>(input.centre_is_code, input.layout.full_value());
  read_components<T>(input, mapping, samples, count, out);
  return make_unit(static_cast<std::size_t>(count), mapping.least, out[0], out[1], out[2], out[3]);
}

}  // namespace

bool NormalInput::decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
  return visit_sample_type(layout.type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T> && sizeof(T) == 4) {
      return false;  // refused when the input was chosen
    } else {
      return decode<T>(*this, samples, count, out);
    }
  });
}

Result<NormalInput> choose_normal_input(const Options& options, const SampleLayout& layout) {
  if (layout.value_bands != 2 && layout.value_bands != 3)
    return fail(ErrorCode::kUnsupported, "normals need two bands (x, y) or three (x, y, z), found " + std::to_string(layout.value_bands) +
                                             "; choose with `bands`, for example `bands` 1,2,3");
  if (layout.type == SampleType::kUint32 || layout.type == SampleType::kInt32)
    return fail(ErrorCode::kUnsupported, std::string("normals from ") + sample_name(layout.type) +
                                             " samples have no customary meaning; use 8 or 16 bits, or floats");
  if (layout.range)
    return fail(ErrorCode::kUnsupported, "a range does not apply to normals, whose components go from -1 to 1; leave `range` out");
  constexpr std::array<std::string_view, 2> kCentres{"128", "127.5"};
  constexpr std::array<std::string_view, 2> kDirections{"up", "down"};
  VT_ASSIGN(const std::string centre, choice_of(options, "zero", kCentres[0], kCentres));
  VT_ASSIGN(const std::string y, choice_of(options, "y", kDirections[0], kDirections));
  return NormalInput{.layout = layout, .centre_is_code = centre == kCentres[0], .y_is_down = y == kDirections[1]};
}

}  // namespace vt::channels
