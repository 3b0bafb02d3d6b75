// What every tile texture shows now and what it should show. Each tile is double-buffered: the shown texture
// stays as it is until the hidden one is complete, then they swap, so no frame sees half a tile. Knows no GL
// and no disk; belongs to the GL thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/paging.h"
#include "runtime/selection.h"

namespace vt::runtime {

// Says which content a slot was meant to get; a result whose ticket is no longer the slot's is stale.
using Ticket = std::uint64_t;

struct Slot {
  int level = 0;       // index into VtLayout::levels
  TexelOrigin target;  // where the tile belongs
  TexelOrigin shown;   // what its front texture holds
  bool has_target = false;
  bool is_shown = false;  // the front texture holds a complete tile
  bool failed = false;    // the target could not be read; not tried again until it changes
  Ticket ticket = 0;
  int front = 0;  // which of its two textures is shown

  [[nodiscard]] bool wants_load() const { return has_target && !failed && !(is_shown && shown == target); }
};

class Residency {
 public:
  explicit Residency(VtLayout layout);

  [[nodiscard]] const VtLayout& layout() const { return layout_; }
  [[nodiscard]] std::span<const Slot> slots() const { return slots_; }
  [[nodiscard]] const Slot& slot(int index) const { return slots_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const LevelLayout& level_of(int slot_index) const {
    return layout_.levels[static_cast<std::size_t>(slot(slot_index).level)];
  }

  // Moves a level's box. Tiles that already show a wanted place keep it; true when any slot now wants
  // something else.
  bool center_level(int level_index, double s, double t);
  [[nodiscard]] TexelOrigin level_origin(int level_index) const { return origins_[static_cast<std::size_t>(level_index)]; }

  // The slot's hidden texture is complete: shows it. `ticket` is the slot's own.
  void swap(int slot_index, Ticket ticket);
  void mark_failed(int slot_index, Ticket ticket);
  // Forgets all content, as after a lost context. Targets stay.
  void forget_content();

  [[nodiscard]] std::span<const SelectableLevel> selectable() const { return levels_; }
  [[nodiscard]] int waiting() const;  // slots that want a load

 private:
  void refresh(int level_index);

  VtLayout layout_;
  std::vector<Slot> slots_;            // level by level, finest first
  std::vector<int> first_slot_;        // of each level
  std::vector<TexelOrigin> origins_;   // of each level's box
  std::vector<bool> placed_;           // whether a level has been centered yet
  std::vector<SelectableTile> tiles_;  // one a slot
  std::vector<SelectableLevel> levels_;
  Ticket next_ticket_ = 1;
};

}  // namespace vt::runtime
