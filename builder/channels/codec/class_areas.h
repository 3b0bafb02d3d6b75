// Texels of the finest level that lie over many samples: how much of each texel every class holds, before it
// is counted in whole units. Arithmetic only; a value belongs to one thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "store/tile_id.h"

namespace vt::channels {

struct ClassArea {
  float id = 0.0F;    // as decoded: it may be none that the layer can hold
  double area = 0.0;  // of the texel, above 0; those of all classes are 1 or, where there are voids, less
};

// Adds `area` to a list that is in ascending order of classes.
inline void add_class_area(std::vector<ClassArea>& list, float id, double area) {
  std::size_t at = list.size();
  while (at > 0 && list[at - 1].id > id) --at;
  if (at > 0 && list[at - 1].id == id) {
    list[at - 1].area += area;
  } else {
    list.insert(list.begin() + static_cast<std::ptrdiff_t>(at), {id, area});
  }
}

// A rectangle of texels, each with its classes in ascending order; none without data.
class ClassAreaBlock {
 public:
  // All texels without data.
  void reset(const TexelRect& rect) {
    rect_ = rect;
    lists_.assign(static_cast<std::size_t>(rect.width * rect.height), {});
    entries_.clear();
  }
  void set(std::int64_t x, std::int64_t y, std::span<const ClassArea> classes) {
    lists_[index_of(x, y)] = {entries_.size(), static_cast<std::uint32_t>(classes.size())};
    entries_.insert(entries_.end(), classes.begin(), classes.end());
  }
  [[nodiscard]] const TexelRect& rect() const { return rect_; }
  [[nodiscard]] std::span<const ClassArea> at(std::int64_t x, std::int64_t y) const {
    const List& list = lists_[index_of(x, y)];
    return std::span(entries_).subspan(list.first, list.count);
  }

 private:
  struct List {
    std::size_t first = 0;
    std::uint32_t count = 0;
  };
  [[nodiscard]] std::size_t index_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y - rect_.y) * rect_.width + (x - rect_.x));
  }

  TexelRect rect_;
  std::vector<List> lists_;
  std::vector<ClassArea> entries_;
};

}  // namespace vt::channels
