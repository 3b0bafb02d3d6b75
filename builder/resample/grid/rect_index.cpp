#include "builder/resample/grid/rect_index.h"

#include <algorithm>
#include <cmath>

namespace vt::resample {
namespace {

bool meet(const TexelRect& a, const TexelRect& b) { return a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom(); }

std::int64_t twice_centre_x(const TexelRect& r) { return r.x + r.right(); }
std::int64_t twice_centre_y(const TexelRect& r) { return r.y + r.bottom(); }

}  // namespace

TexelRect united(const TexelRect& a, const TexelRect& b) {
  const std::int64_t x = std::min(a.x, b.x);
  const std::int64_t y = std::min(a.y, b.y);
  return {x, y, std::max(a.right(), b.right()) - x, std::max(a.bottom(), b.bottom()) - y};
}

// Sort-tile-recursive packing (Leutenegger, Lopez, Edgington 1997): rectangles in strips from north to south,
// each strip from west to east, so that neighbours in the array are neighbours on the ground. Ties are broken
// by number: the tree depends on nothing but its input.
RectIndex::RectIndex(std::span<const TexelRect> rects) {
  for (std::size_t i = 0; i < rects.size(); ++i)
    if (!rects[i].empty()) nodes_.push_back({rects[i], static_cast<std::uint32_t>(i), 0});
  if (nodes_.empty()) return;
  std::ranges::sort(nodes_, {}, [](const Node& n) { return std::pair(twice_centre_y(n.bounds), n.first); });
  const double leaves = std::ceil(static_cast<double>(nodes_.size()) / kFanout);
  const auto strip = static_cast<std::size_t>(std::ceil(std::sqrt(leaves))) * kFanout;
  for (std::size_t at = 0; at < nodes_.size(); at += strip) {
    const auto end = static_cast<std::ptrdiff_t>(std::min(at + strip, nodes_.size()));
    std::sort(nodes_.begin() + static_cast<std::ptrdiff_t>(at), nodes_.begin() + end, [](const Node& a, const Node& b) {
      return std::pair(twice_centre_x(a.bounds), a.first) < std::pair(twice_centre_x(b.bounds), b.first);
    });
  }
  for (std::size_t begin = 0, end = nodes_.size(); end - begin > 1;) {
    for (std::size_t at = begin; at < end; at += kFanout) {
      Node parent{nodes_[at].bounds, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(std::min(kFanout, end - at))};
      for (std::size_t i = at; i < at + parent.count; ++i) parent.bounds = united(parent.bounds, nodes_[i].bounds);
      nodes_.push_back(parent);
    }
    begin = end;
    end = nodes_.size();
  }
}

template <class Visit>
bool RectIndex::visit(const TexelRect& rect, std::uint32_t index, const Visit& visit_rect) const {
  const Node& node = nodes_[index];
  if (!meet(node.bounds, rect)) return true;
  if (node.count == 0) return visit_rect(node.first);
  for (std::uint32_t child = node.first; child < node.first + node.count; ++child)
    if (!visit(rect, child, visit_rect)) return false;
  return true;
}

bool RectIndex::touches(const TexelRect& rect) const {
  if (nodes_.empty() || rect.empty()) return false;
  return !visit(rect, static_cast<std::uint32_t>(nodes_.size() - 1), [](std::uint32_t) { return false; });
}

void RectIndex::find(const TexelRect& rect, std::vector<std::uint32_t>& out) const {
  out.clear();
  if (nodes_.empty() || rect.empty()) return;
  visit(rect, static_cast<std::uint32_t>(nodes_.size() - 1), [&](std::uint32_t number) {
    out.push_back(number);
    return true;
  });
  std::ranges::sort(out);
}

bool covers(std::span<const TexelRect> parts, const TexelRect& whole) {
  if (whole.empty()) return true;
  // Between two neighbouring horizontal edges every part either spans the strip or does not touch it.
  std::vector<std::int64_t> edges{whole.y, whole.bottom()};
  for (const TexelRect& part : parts) {
    const TexelRect inside = intersect(part, whole);
    if (inside.empty()) continue;
    if (inside == whole) return true;
    edges.push_back(inside.y);
    edges.push_back(inside.bottom());
  }
  std::ranges::sort(edges);
  edges.erase(std::ranges::unique(edges).begin(), edges.end());
  std::vector<std::pair<std::int64_t, std::int64_t>> spans;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    spans.clear();
    for (const TexelRect& part : parts)
      if (part.y <= edges[i] && part.bottom() >= edges[i + 1]) spans.emplace_back(part.x, part.right());
    std::ranges::sort(spans);
    std::int64_t reached = whole.x;
    for (const auto& [west, east] : spans) {
      if (west > reached) break;
      reached = std::max(reached, east);
    }
    if (reached < whole.right()) return false;
  }
  return true;
}

}  // namespace vt::resample
