// What the samples of one band of a raster stand for, as far as its file says. Made by the readers, used by
// every channel. Plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vt::source {

enum class BandRole : std::uint8_t {
  kUnknown,  // the file does not say
  kGrey,
  kRed,
  kGreen,
  kBlue,
  kCoverage,  // alpha, or a mask
  kIndex,     // into a palette
  kOther,     // said to be something else: infrared, depth, no colour at all
};

struct BandMeaning {
  BandRole role = BandRole::kUnknown;
  // The sample that means "all of it": 2^bits - 1 of unsigned integers, 2^(bits - 1) - 1 of signed ones, 1 of
  // floating point, and of a mask whatever its covered samples are.
  double full_scale = 1.0;
  std::optional<double> scale;   // value = offset + scale * sample, where the file declares it
  std::optional<double> offset;  // likewise
  std::string unit;              // of that value, in the file's own words; "" when it does not say
  std::optional<double> nodata;  // the sample that means "no data", as the file declares it
};

// What a file says of its samples in case they are heights, and of nothing else: its coordinates are of three
// dimensions. Which band holds heights it does not say. What a band declares of itself goes before this.
struct HeightMeaning {
  std::string unit;              // as BandMeaning has it
  std::optional<double> scale;   // value = offset + scale * sample, in `unit`
  std::optional<double> offset;  // likewise
  bool counts_down = false;      // numbers are depths
};

// The role behind a name that GDAL gives to colour interpretations: "Red", "Alpha", ...; kOther for what is
// none of ours.
[[nodiscard]] BandRole role_from_name(std::string_view name);

}  // namespace vt::source
