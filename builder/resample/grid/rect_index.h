// Which of many rectangles touch a given one, without asking each. A static tree of bounding rectangles,
// packed by place: memory proportional to the number of rectangles however they overlap, a query proportional
// to what it finds. Immutable; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "store/tile_id.h"

namespace vt::resample {

class RectIndex {
 public:
  RectIndex() = default;
  // Empty rectangles are never found.
  explicit RectIndex(std::span<const TexelRect> rects);

  [[nodiscard]] bool touches(const TexelRect& rect) const;
  // Puts the numbers of all rectangles that share a texel with `rect` into `out`, ascending.
  void find(const TexelRect& rect, std::vector<std::uint32_t>& out) const;

 private:
  static constexpr std::size_t kFanout = 8;

  struct Node {
    TexelRect bounds;
    std::uint32_t first = 0;  // child node, or number of a rectangle in the lowest layer
    std::uint32_t count = 0;  // of children; 0 in the lowest layer
  };

  // Calls visit(number) for each; stops when it returns false.
  template <class Visit>
  bool visit(const TexelRect& rect, std::uint32_t node, const Visit& visit_rect) const;

  std::vector<Node> nodes_;  // lowest layer first, the root last
};

// The least rectangle around both, which are not empty.
[[nodiscard]] TexelRect united(const TexelRect& a, const TexelRect& b);

// Whether every texel of `whole` lies in at least one of `parts`.
[[nodiscard]] bool covers(std::span<const TexelRect> parts, const TexelRect& whole);

}  // namespace vt::resample
