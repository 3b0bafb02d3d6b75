#include "runtime/selection.h"

#include <algorithm>
#include <cassert>

namespace vt::runtime {
namespace {

// The part of a box that no tile covers yet, as disjoint boxes. Fixed memory: when it would not suffice, a
// piece that is covered in truth stays listed, which costs a stage and never a hole.
class Uncovered {
 public:
  explicit Uncovered(const Box& box) : pieces_{box}, count_(1) {}

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool meets(const Box& tile) const {
    return std::any_of(pieces_.begin(), pieces_.begin() + count_, [&](const Box& piece) { return tile.meets(piece); });
  }

  void remove(const Box& tile) {
    int kept = 0;
    std::array<Box, kCapacity> next;
    for (int i = 0; i < count_; ++i) {
      const Box& p = pieces_[i];
      const int waiting = count_ - i - 1;
      if (!tile.meets(p) || kept + 4 + waiting > kCapacity) {
        next[kept++] = p;
        continue;
      }
      // What remains: a strip south, a strip north, and between them a strip west and a strip east.
      const double south = std::max(p.t_min, tile.t_min);
      const double north = std::min(p.t_max, tile.t_max);
      if (p.t_min < south) next[kept++] = {p.s_min, p.t_min, p.s_max, south};
      if (north < p.t_max) next[kept++] = {p.s_min, north, p.s_max, p.t_max};
      if (p.s_min < tile.s_min) next[kept++] = {p.s_min, south, tile.s_min, north};
      if (tile.s_max < p.s_max) next[kept++] = {tile.s_max, south, p.s_max, north};
    }
    pieces_ = next;
    count_ = kept;
  }

 private:
  // k tiles cut the plane into at most (2k + 1)^2 cells; the strips above are far fewer.
  static constexpr int kCapacity = 256;
  std::array<Box, kCapacity> pieces_;
  int count_;
};

struct Found {
  int level = -1;
  const SelectableTile* tile = nullptr;
};

Found finest_single(std::span<const SelectableLevel> levels, const Box& box) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const SelectableLevel& level = levels[i];
    if (!level.any_shown || !level.box.grown_by(level.tolerance).contains(box)) continue;
    for (const SelectableTile& tile : level.tiles)
      if (tile.shown && tile.box.grown_by(level.tolerance).contains(box)) return {static_cast<int>(i), &tile};
  }
  return {};
}

// For geometry that reaches outside the virtual texture: its coarsest tile, stretched at the edge.
const SelectableTile* last_resort(std::span<const SelectableLevel> levels) {
  for (std::size_t i = levels.size(); i-- > 0;)
    for (const SelectableTile& tile : levels[i].tiles)
      if (tile.shown) return &tile;
  return nullptr;
}

}  // namespace

StageSet select_one(std::span<const SelectableLevel> levels, const Box& box) {
  StageSet set;
  const Found found = finest_single(levels, box);
  const SelectableTile* tile = found.tile != nullptr ? found.tile : last_resort(levels);
  if (tile == nullptr) return set;
  set.slots[0] = tile->slot;
  set.count = 1;
  set.covers = found.tile != nullptr;
  return set;
}

StageSet select_stages(std::span<const SelectableLevel> levels, const Box& box, int cap) {
  assert(cap >= 1 && cap <= kMaxStages);
  const Found single = finest_single(levels, box);
  const SelectableTile* base = single.tile != nullptr ? single.tile : last_resort(levels);
  if (base == nullptr) return {};
  const std::size_t finer_levels = single.tile != nullptr ? static_cast<std::size_t>(single.level) : levels.size();

  // Finer tiles, as long as they show something that finer ones still leave open.
  StageSet set;
  Uncovered open(box);
  for (std::size_t i = 0; i < finer_levels; ++i) {
    const SelectableLevel& level = levels[i];
    if (!level.any_shown || !level.box.meets(box)) continue;
    for (const SelectableTile& tile : level.tiles) {
      if (!tile.shown || &tile == base || !tile.box.meets(box) || !open.meets(tile.box)) continue;
      if (set.count == cap) {
        // One stage too many: the last one has to be the tile that covers everything.
        set.slots[cap - 1] = base->slot;
        set.covers = single.tile != nullptr;
        return set;
      }
      set.slots[set.count++] = tile.slot;
      open.remove(tile.box.grown_by(level.tolerance));
      if (open.empty()) {
        set.covers = true;
        return set;
      }
    }
  }
  if (set.count == cap) --set.count;
  set.slots[set.count++] = base->slot;
  set.covers = single.tile != nullptr;
  return set;
}

}  // namespace vt::runtime
