// Rows of texels that know how much of their area each class holds. Areas are whole numbers of texels of the
// layer's finest level, or of a fixed part of them where these are of several classes themselves, so that
// sums are exact at every level and in any order; area without data, or outside the data rectangle, is
// counted for no class. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/channels/codec/class_areas.h"
#include "builder/channels/codec/class_planes.h"
#include "store/format/layout.h"

namespace vt::pyramid {

// The greatest area is 2 to this: the coarsest texel of a layer with all levels that there can be, in halves
// of the finest texels.
inline constexpr int kMostAreaBits = 2 * store::kMaxFinest + 1;
inline constexpr int kAreaBits = kMostAreaBits + 1;

// One class of a texel: its area in the lower kAreaBits, the class above them. Sums of areas never reach the
// class; the order of the numbers is the order of the classes.
using ClassCount = std::uint64_t;

inline constexpr ClassCount kAreaMask = (ClassCount{1} << kAreaBits) - 1;
static_assert(ClassCount{channels::kGreatestClass} <= ~ClassCount{0} >> kAreaBits, "a count has no room for the class");

[[nodiscard]] constexpr ClassCount class_count(std::uint64_t id, std::uint64_t area) { return id << kAreaBits | area; }
[[nodiscard]] constexpr std::uint32_t class_of(ClassCount count) { return static_cast<std::uint32_t>(count >> kAreaBits); }
[[nodiscard]] constexpr std::uint64_t area_of(ClassCount count) { return count & kAreaMask; }

// A row of texels, each with its classes in ascending order; none without data. One texel more lies on either
// side, for pairs that reach over the edge: without data, unless put_past_end() says otherwise.
class CountRow {
 public:
  CountRow() { begin(0); }
  // A row of `texels` without data.
  static CountRow nothing(std::int64_t texels);

  // Starts anew: `classes` is how many entries will be added at most, other than by append(). Then
  // end_texel() after each texel's entries, and finish().
  void begin(std::size_t classes);
  void append(std::span<const ClassCount> classes);
  void add(ClassCount count) { entries_[used_++] = count; }
  void end_texel() { ends_.push_back(static_cast<std::uint32_t>(used_)); }
  void finish() { end_texel(); }
  // What the east end of a finished row is followed by. `classes` are not this row's own entries.
  void put_past_end(std::span<const ClassCount> classes) {
    append(classes);
    ends_.back() = static_cast<std::uint32_t>(used_);
  }

  // Where the next entries go, for callers that write several at once and then say how many.
  [[nodiscard]] ClassCount* next() { return entries_.data() + used_; }
  void added(std::size_t count) { used_ += count; }

  // The classes of texel `i`, -1 to texels().
  [[nodiscard]] std::span<const ClassCount> texel(std::int64_t i) const {
    const auto at = static_cast<std::size_t>(i + 1);
    return {entries_.data() + ends_[at], ends_[at + 1] - ends_[at]};
  }
  [[nodiscard]] std::int64_t texels() const { return static_cast<std::int64_t>(ends_.size()) - 3; }
  // Offsets into entries(): texel i, -1 to texels(), has those from offsets()[i + 1] to offsets()[i + 2].
  [[nodiscard]] const std::uint32_t* offsets() const { return ends_.data(); }
  [[nodiscard]] const ClassCount* entries() const { return entries_.data(); }
  [[nodiscard]] std::size_t entry_count() const { return used_; }

 private:
  std::vector<std::uint32_t> ends_;
  std::vector<ClassCount> entries_;  // used_ of them are the row's
  std::size_t used_ = 0;
};

// A row of the finest level; readable one texel beyond either side.
struct ClassRow {
  const float* classes;  // whole, 0 to kGreatestClass
  const float* weights;  // 0 or 1
};

// `count` texels of the next coarser level; texel i covers the columns start + 2 i and start + 2 i + 1 of
// both rows.
void count_classes(const ClassRow& upper, const ClassRow& lower, std::int64_t start, std::int64_t count, CountRow& out);
void add_counts(const CountRow& upper, const CountRow& lower, std::int64_t start, std::int64_t count, CountRow& out);

// The areas of a texel of `full_area`, appended to `out`: areas rounded to whole ones such that they and the
// part without data sum to it. Each is rounded down, then those that lost most get one more (the method of
// largest remainders; of equal remainders the lowest class first, what is without data last).
void count_areas(std::span<const channels::ClassArea> classes, std::uint64_t full_area, std::vector<ClassCount>& out);

// The planes of channels/class_planes.h of all texels of `row`, each of which covers `full_area`. Of equally
// frequent classes the lowest comes first. Returns whether all weights are exactly 1.
bool rank_classes(const CountRow& row, std::uint64_t full_area, int ranked, const channels::PlaneRow& out);

}  // namespace vt::pyramid
