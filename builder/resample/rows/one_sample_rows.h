// Texels whose footprint is one sample: between the four nearest samples, or the nearest as it is. Private to
// this folder. One object per thread, reused.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/resample/grid/sample_grid.h"
#include "builder/resample/rows/texel_footprints.h"

namespace vt::resample {

class OneSampleRows {
 public:
  // All planes of `count` texels from column `x` of a row on, by the sources' method, into `out`. The window
  // holds the source planes of all samples that they need; texels of another kind become anything.
  void make(const GridSources& sources, const SampleWindow& window, const TexelFootprints& texels, std::int64_t x, std::int64_t y,
            std::int64_t count, const channels::PlaneRow& out);

 private:
  using Kind = TexelFootprints::Kind;

  void find_four(const TexelRect& raster, const PlaneBlock& block, const Kind* kinds, const Point2* centres, std::size_t count);
  void interpolate_runs(const SampleWindow& window, std::size_t count, const channels::PlaneRow& out) const;
  void interpolate_wide(std::span<const channels::PlaneRule> rules, const PlaneBlock& block, std::size_t count,
                        const channels::PlaneRow& out) const;
  void mend_gaps(std::span<const channels::PlaneRule> rules, const SampleWindow& window, const Kind* kinds, std::size_t count,
                 const channels::PlaneRow& out) const;
  static void pick(const PlaneBlock& block, const Kind* kinds, const Point2* centres, std::size_t count, const channels::PlaneRow& out);

  // For each texel: the offset of its north-western sample in a plane of the window, and from there to the
  // southern and the eastern one.
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> down_;
  std::vector<std::uint32_t> right_;
  std::vector<float> fraction_x_;  // between these samples
  std::vector<float> fraction_y_;
};

}  // namespace vt::resample
