// Sources on another grid than the layer's: for a part of the layer, the window of samples that it needs, and its texels by interpolation
// in filter space. Private to this room. Threads: the buffers belong to one thread, all else is shared and immutable.
#pragma once

#include <vector>

#include "builder/resample/placed_source.h"
#include "builder/resample/plane_block.h"
#include "store/result.h"

namespace vt::resample {

struct WarpBuffers {
  std::vector<Point2> positions;   // of the texels' centres in the source
  std::vector<std::byte> samples;  // a window of the source
  std::vector<float> planes;       // the same, decoded
  std::vector<float> row;          // one row of texels
};

// Samples of a source that are decoded at once, at most (or the neighbourhood of a single texel).
inline constexpr std::int64_t kMostWindowSamples = std::int64_t{1} << 18;

// Lays the source's texels of `part` over `target`. What is read is added to `content` when it is given.
[[nodiscard]] Result<void> composite_warped(const PlacedSource& source, const TexelRect& part, WarpBuffers& buffers, PlaneBlock& target,
                                            store::ContentHasher* content);

// Adds to `content` what composite_warped would add, without decoding.
[[nodiscard]] Result<void> hash_warped(const PlacedSource& source, const TexelRect& part, WarpBuffers& buffers,
                                       store::ContentHasher& content);

}  // namespace vt::resample
