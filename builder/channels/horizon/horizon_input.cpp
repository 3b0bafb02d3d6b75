#include "builder/channels/horizon/horizon_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <span>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/shared/angle.h"
#include "builder/channels/shared/declared_unit.h"

namespace vt::channels {
namespace {

constexpr auto kRightAngle = static_cast<float>(std::numbers::pi / 2.0);
constexpr std::int64_t kAtOnce = 256;                         // texels of a row that are read together
constexpr float kBeyondRightAngle = kRightAngle * 1.000001F;  // a right angle in degrees, brought into radians, may round up

// Bands into `band_planes` as radians, one of each. Returns whether all of them are horizons (or deviations);
// `is_horizon` tells of each texel.
template <class T>
bool read_angles(const HorizonInput& input, const std::byte* samples, std::int64_t count, std::span<float* const> band_planes,
                 std::uint8_t* is_horizon) {
  const auto radians_per_unit = static_cast<float>(input.radians_per_unit);
  const auto radians_of_zero = static_cast<float>(input.radians_of_zero);
  const std::size_t texel_bytes = band_planes.size() * sizeof(T);
  bool all = true;
  std::fill_n(is_horizon, count, std::uint8_t{1});
  for (std::size_t b = 0; b < band_planes.size(); ++b) {
    const float least = input.has_deviations && b % 2 == 1 ? 0.0F : -kBeyondRightAngle;
    const TypedNodataRange<T> nodata = typed_nodata_range<T>(input.layout, b);
    // A deviation knows of scales, but not of where zero is.
    const float zero = input.has_deviations && b % 2 == 1 ? 0.0F : radians_of_zero;
    const std::byte* sample = samples + b * sizeof(T);
    for (std::int64_t i = 0; i < count; ++i, sample += texel_bytes) {
      T number;
      std::memcpy(&number, sample, sizeof number);
      const float angle = zero + static_cast<float>(number) * radians_per_unit;
      // False for NaN.
      const bool is_angle = angle >= least && angle <= kBeyondRightAngle && !nodata.contains(number);
      band_planes[b][i] = std::min(std::max(angle, -kRightAngle), kRightAngle);
      is_horizon[i] &= static_cast<std::uint8_t>(is_angle);
      all = all && is_angle;
    }
  }
  return all;
}

template <class T>
bool decode_piece(const HorizonInput& input, const std::byte* samples, std::int64_t count, std::int64_t first, const PlaneRow& out) {
  const std::size_t directions = input.directions();
  const std::size_t bands = input.source_planes() - 1;
  std::array<std::uint8_t, kAtOnce> is_horizon;
  // Bands in the order of the samples; a deviation goes where its direction's mean square will be.
  std::array<float*, 2 * kMostDirections> band_planes{};
  for (std::size_t b = 0; b < bands; ++b) band_planes[b] = out[!input.has_deviations ? b : b % 2 == 0 ? b / 2 : directions + b / 2] + first;
  const bool all = read_angles<T>(input, samples, count, std::span(band_planes).first(bands), is_horizon.data());
  if (input.has_deviations)
    for (std::size_t d = 0; d < directions; ++d)
      for (std::int64_t i = first; i < first + count; ++i) {
        const float deviation = out[directions + d][i];
        out[directions + d][i] = out[d][i] * out[d][i] + deviation * deviation;
      }
  std::fill_n(out[bands] + first, count, 1.0F);
  if (all) return true;
  for (std::int64_t i = 0; i < count; ++i)
    if (is_horizon[static_cast<std::size_t>(i)] == 0)
      for (std::size_t p = 0; p <= bands; ++p) out[p][first + i] = 0.0F;
  return false;
}

template <class T>
bool decode(const HorizonInput& input, const std::byte* samples, std::int64_t count, const PlaneRow& out) {
  const std::int64_t texel_bytes = static_cast<std::int64_t>((input.source_planes() - 1) * sizeof(T));
  bool all = true;
  for (std::int64_t first = 0; first < count; first += kAtOnce)
    all = decode_piece<T>(input, samples + first * texel_bytes, std::min(kAtOnce, count - first), first, out) && all;
  return all;
}

// Without a choice: east and west of two, evenly from north of more.
Result<std::vector<double>> choose_azimuths(const Options& options, std::size_t directions) {
  VT_ASSIGN(std::vector<double> azimuths, numbers_of(options, "azimuths"));
  if (azimuths.empty()) {
    if (directions == 1)
      return fail(ErrorCode::kUsage,
                  "a horizon in one direction needs to be told which; give `azimuths` with degrees clockwise from north");
    if (directions == 2) return std::vector<double>{90.0, 270.0};
    for (std::size_t d = 0; d < directions; ++d) azimuths.push_back(360.0 * static_cast<double>(d) / static_cast<double>(directions));
    return azimuths;
  }
  if (azimuths.size() != directions)
    return fail(ErrorCode::kUsage, "option azimuths: " + std::to_string(azimuths.size()) + " directions are named, the bands hold " +
                                       std::to_string(directions) + "; choose bands with `bands`");
  for (std::size_t d = 0; d < directions; ++d) {
    if (azimuths[d] < 0.0 || azimuths[d] >= 360.0)
      return fail(ErrorCode::kUsage, "option azimuths: directions are degrees clockwise from north, from 0 to less than 360");
    for (std::size_t before = 0; before < d; ++before)
      if (azimuth_name(azimuths[before]) == azimuth_name(azimuths[d]))
        return fail(ErrorCode::kUsage, "option azimuths: " + azimuth_name(azimuths[d]) + " is named twice");
  }
  return azimuths;
}

}  // namespace

bool HorizonInput::decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
  return visit_sample_type(layout.type, [&]<class T>(std::type_identity<T>) { return decode<T>(*this, samples, count, out); });
}

std::string azimuth_name(double azimuth_deg) {
  constexpr std::array<const char*, 8> kPoints{"north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"};
  const double eighth = azimuth_deg / 45.0;
  if (eighth == std::floor(eighth)) return kPoints[static_cast<std::size_t>(eighth) % 8];
  std::array<char, 16> text{};
  const bool is_whole = azimuth_deg == std::floor(azimuth_deg);
  std::snprintf(text.data(), text.size(), is_whole ? "az%03.0f" : "az%05.1f", azimuth_deg);
  return text.data();
}

// Radians of one: what the user says, else what the file declares, else radians.
Result<double> choose_angle_unit(const Options& options, const SampleLayout& layout) {
  constexpr std::array<std::string_view, 2> kChoices{"rad", "deg"};
  VT_ASSIGN(const std::string given, choice_of(options, "angles", kChoices[0], kChoices));
  const bool is_declared = !options.contains("angles") && !layout.unit.empty();
  if (const auto radians = radians_of_unit(is_declared ? layout.unit : given)) return *radians;
  return fail(ErrorCode::kInvalidData,
              "declares its angles in '" + layout.unit +
                  "', which is no unit of angles that is known; say what they are with `angles` rad or `angles` deg");
}

Result<HorizonInput> choose_horizon_input(const Options& options, const SampleLayout& layout) {
  constexpr std::array<std::string_view, 2> kDeviations{"none", "given"};
  VT_ASSIGN(const double radians_per_unit, choose_angle_unit(options, layout));
  VT_ASSIGN(const std::string deviations, choice_of(options, "deviations", kDeviations[0], kDeviations));
  HorizonInput input{.layout = layout, .radians_per_unit = radians_per_unit, .has_deviations = deviations == kDeviations[1]};
  input.radians_of_zero = layout.offset.value_or(0.0) * input.radians_per_unit;
  input.radians_per_unit *= layout.scale.value_or(1.0);
  if (radians_per_unit == 1.0 && !layout.scale && layout.type != SampleType::kFloat32 && layout.type != SampleType::kFloat64)
    return fail(ErrorCode::kUsage, std::string("horizons from ") + sample_name(layout.type) +
                                       " samples cannot be radians; if they are degrees, say `angles` deg");
  if (layout.range)
    return fail(ErrorCode::kUsage,
                "a range of samples does not apply to horizons, which are angles; for the range that is stored use `span`");
  const std::size_t bands = static_cast<std::size_t>(layout.value_bands);
  const std::size_t bands_each = input.has_deviations ? 2 : 1;
  if (bands % bands_each != 0 || bands / bands_each < 1 || bands / bands_each > kMostDirections)
    return fail(ErrorCode::kUnsupported,
                "horizons need a band (with `deviations` given a pair of bands) for each of 1 to 24 directions, found " +
                    std::to_string(bands) + "; choose with `bands`");
  VT_ASSIGN(input.azimuths_deg, choose_azimuths(options, bands / bands_each));
  return input;
}

}  // namespace vt::channels
