// Samples of horizon maps as moments of angles. Owns which directions the bands are, their unit, and what is
// no data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "store/result.h"

namespace vt::channels {

inline constexpr std::size_t kMostDirections = 24;

struct HorizonInput {
  SampleLayout layout;
  std::vector<double> azimuths_deg;  // clockwise from north, in the order of the bands
  double radians_per_unit = 1.0;     // of a sample, a scale that the file declares included
  double radians_of_zero = 0.0;
  bool has_deviations = false;  // bands are pairs of mean and standard deviation, not single angles

  [[nodiscard]] std::size_t directions() const { return azimuths_deg.size(); }
  // Planes: a mean for each direction; with deviations a mean square for each; the weight.
  [[nodiscard]] std::size_t source_planes() const { return directions() * (has_deviations ? 2 : 1) + 1; }

  // `count` texels into the source planes, weights 1 or 0. A texel has data when all its directions do: a
  // number that is not a horizon (not finite, beyond 90 degrees, declared nodata, a negative deviation)
  // leaves the whole texel without. Returns whether all weights are 1.
  bool decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const;
};

// "east", "north-west" or "az022.5": of a direction, for the names of components and layers.
[[nodiscard]] std::string azimuth_name(double azimuth_deg);

// kUsage, kUnsupported: see make_codec().
[[nodiscard]] Result<HorizonInput> choose_horizon_input(const Options& options, const SampleLayout& layout);

}  // namespace vt::channels
