// Sources whose samples lie on one grid, read as one raster: later ones lie over earlier ones, sample by
// sample, in filter space. The grid is the layer's own, or that of the sources; then the raster is resampled
// as a whole, so that nothing shows where one file ends and the next begins. Private to this folder. Threads:
// immutable once made; windows and buffers belong to one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/resample/grid/placed_source.h"
#include "builder/resample/grid/plane_block.h"
#include "builder/resample/grid/rect_index.h"
#include "store/io/content_hash.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::resample {

// Some samples of a grid in filter space. Reused from call to call, so that its buffers are allocated once.
struct SampleWindow {
  PlaneBlock block;                 // no data where there is no raster
  bool is_opaque = false;           // every weight is exactly 1
  std::vector<std::uint8_t> there;  // of each sample, 1: it lies in a raster. Empty: all do

  // Buffers of SampleGrid.
  std::vector<std::uint32_t> found;
  std::vector<std::byte> samples;
  std::vector<float> upper;

  [[nodiscard]] const std::uint8_t* there_at(std::int64_t x, std::int64_t row) const {
    return there.empty() ? nullptr : there.data() + (row - block.rect.y) * block.rect.width + (x - block.rect.x);
  }
};

// Rectangles are of samples of the grid.
class SampleGrid {
 public:
  struct Member {
    const PlacedSource* source;
    TexelRect rect;
  };
  // One source in a window.
  struct Part {
    const Member* member;
    TexelRect rect;
    bool lies_over_another;  // of the parts before it

    // In the source's own columns and rows.
    [[nodiscard]] source::Window window() const { return {rect.x - member->rect.x, rect.y - member->rect.y, rect.width, rect.height}; }
  };

  // `source` outlives the grid; its first sample is at column `x`, row `y`. After the last one make_index().
  void add(const PlacedSource& source, std::int64_t x, std::int64_t y);
  void make_index();

  [[nodiscard]] const std::vector<Member>& members() const { return members_; }
  [[nodiscard]] const RectIndex& index() const { return index_; }
  // The box around all members.
  [[nodiscard]] const TexelRect& bounds() const { return bounds_; }

  // The parts of `window`, in order. Sources under opaque ones are left out: they are neither read nor do
  // they count as content.
  void find_parts(const TexelRect& window, std::vector<std::uint32_t>& found, std::vector<Part>& parts) const;
  // One member hides all that lies below it in `window`.
  [[nodiscard]] bool hides(const TexelRect& window, std::vector<std::uint32_t>& found) const;

  // Puts what all members together hold of `window` into `out`, in the source planes or, when `derived`, in
  // all planes of the codec. Adds to `content`, when it is given, all that decides the result.
  [[nodiscard]] Result<void> read(const TexelRect& window, bool derived, SampleWindow& out, store::ContentHasher* content) const;
  // Adds to `content` exactly what read() would add. Nothing is decoded; `buffers` lends its own.
  [[nodiscard]] Result<void> hash(const TexelRect& window, SampleWindow& buffers, store::ContentHasher& content) const;

 private:
  [[nodiscard]] static Result<void> read_part(const Part& part, bool derived, SampleWindow& out, store::ContentHasher* content);

  std::vector<Member> members_;
  RectIndex index_;
  TexelRect bounds_;
};

}  // namespace vt::resample
