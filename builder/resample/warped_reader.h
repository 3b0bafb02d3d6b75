// Sources on another grid than the layer's become texels of the layer.
//
// One definition: a texel is the mean of the source, taken as constant over each of its samples, over the
// texel's footprint, which is at least one sample wide along each axis of the source. There are two ways to
// compute it.
//
// A footprint of one sample (the layer is as fine as the source, or finer) is the unit square of samples
// around the mapped centre. What it covers of the four samples that it touches are the weights of bilinear
// interpolation: this is bilinear interpolation, and a ramp stays a ramp. Source planes are interpolated, the
// others derived from the result.
//
// A larger one (the layer is coarser than the source) is the quadrilateral between the mapped corners of the
// texel, a side shorter than one sample lengthened to one. Neighbours share their corners, so that every
// sample counts once, however the grids are turned, and sums over a layer are those of its sources. All
// planes are combined as the codec derives them from the samples: linear ones by area, least and greatest
// values over every sample that is touched, classes by the area that each holds. At a ratio r that is no
// whole number the place of a value is off by f (1 - f) / (2 r^2) texels at most, f being the fraction of r:
// 0.0625 at 4/3, 0.010 at 3.5. The value of a surface (ChannelCodec::is_surface) is kept in its place at any
// ratio instead, see surface_run(): at whole ratios that is the mean by area, at others a sample counts for
// up to 12 % (from a ratio of 2 on 6 %) more or less than its area.
//
// The first way is taken up to kMostUnit samples a texel, where it passes over into the second.
// Nearest-neighbour sources take the sample at the mapped centre instead of it, up to kMostPicked, and
// lengthen no side in the second.
//
//   texel_footprints.h: centres, corners, which way  ->  sample_grid.h: windows of samples in filter space
//     ->  one_sample_rows.h, or footprint.h and area_sums.h  ->  texel_block.h: planes of texels, or areas of classes
//
// Windows are bounded: a footprint of a million samples is added up by bands of rows. Beyond the outermost
// centres of samples, up to the raster's edge, the edge sample is repeated. Private to this folder. Threads:
// buffers belong to one thread, all else is shared and immutable.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/resample/grid/footprint.h"
#include "builder/resample/grid/grid_sources.h"
#include "builder/resample/grid/sample_grid.h"
#include "builder/resample/rows/area_sums.h"
#include "builder/resample/rows/one_sample_rows.h"
#include "builder/resample/rows/texel_block.h"
#include "builder/resample/rows/texel_footprints.h"
#include "store/result.h"

namespace vt::resample {

// Samples of a source that are decoded at once, at most (or one row under a single texel).
inline constexpr std::int64_t kMostWindowSamples = std::int64_t{1} << 18;
// Sums that are kept at once, at most (or those of a single texel).
inline constexpr std::int64_t kMostSums = std::int64_t{1} << 17;

struct WarpBuffers {
  TexelFootprints texels;
  SampleWindow window;
  OneSampleRows one_sample;
  std::vector<float> row;  // one row of texels
  std::vector<CoveredRun> columns, touched_columns;
  CoveredRun run;
  PlaneSums plane_sums;
  ClassSums class_sums;
  ColumnSums column_sums;
};

// Makes the texels of `part`, which lies in out.block.rect; all of that is without data, and out.has_areas is
// set, before. `alone`: no other sources are seen there; then texels whose centre lies in no source stay
// without data, and places are not filled in. What is read is added to `content` when it is given.
[[nodiscard]] Result<void> read_warped(const GridSources& sources, const TexelRect& part, bool alone, WarpBuffers& buffers, TexelBlock& out,
                                       store::ContentHasher* content);

// Adds to `content` what read_warped would add, without decoding.
[[nodiscard]] Result<void> hash_warped(const GridSources& sources, const TexelRect& part, bool alone, WarpBuffers& buffers,
                                       store::ContentHasher& content);

}  // namespace vt::resample
