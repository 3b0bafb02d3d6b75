#include "runtime/residency.h"

#include <array>
#include <cassert>
#include <cmath>

namespace vt::runtime {

Residency::Residency(VtLayout layout) : layout_(std::move(layout)) {
  for (std::size_t i = 0; i < layout_.levels.size(); ++i) {
    first_slot_.push_back(static_cast<int>(slots_.size()));
    const int tiles = layout_.levels[i].tiles_per_side * layout_.levels[i].tiles_per_side;
    Slot slot;
    slot.level = static_cast<int>(i);
    slots_.insert(slots_.end(), static_cast<std::size_t>(tiles), slot);
  }
  origins_.resize(layout_.levels.size());
  placed_.resize(layout_.levels.size(), false);
  tiles_.resize(slots_.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) tiles_[i].slot = static_cast<int>(i);
  levels_.resize(layout_.levels.size());
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const LevelLayout& level = layout_.levels[i];
    const auto tiles = static_cast<std::size_t>(level.tiles_per_side * level.tiles_per_side);
    levels_[i].tiles = std::span(tiles_).subspan(static_cast<std::size_t>(first_slot_[i]), tiles);
    levels_[i].tolerance = std::ldexp(1.0, -10 - layout_.store_tile_exponent - level.level.value);
  }
}

bool Residency::center_level(int level_index, double s, double t) {
  const auto index = static_cast<std::size_t>(level_index);
  const LevelLayout& level = layout_.levels[index];
  TexelOrigin& box = origins_[index];
  const TexelOrigin moved = box_origin(layout_, level, s, t, placed_[index] ? &box : nullptr);
  if (placed_[index] && moved == box) return false;
  box = moved;
  placed_[index] = true;

  // Hand out the n x n places: first to slots that show (or are getting) one of them already, then to the
  // others in order.
  const int n = level.tiles_per_side;
  const std::span<Slot> slots = std::span(slots_).subspan(static_cast<std::size_t>(first_slot_[index]), static_cast<std::size_t>(n * n));
  std::array<bool, 64> place_taken{};
  std::array<bool, 64> slot_kept{};
  const auto place_of = [&](TexelOrigin tile) {
    const std::int64_t x = tile.x - moved.x;
    const std::int64_t y = tile.y - moved.y;
    if (x < 0 || y < 0 || x % level.tile_texels() != 0 || y % level.tile_texels() != 0) return -1;
    const std::int64_t column = x / level.tile_texels();
    const std::int64_t row = y / level.tile_texels();
    return column < n && row < n ? static_cast<int>(row * n + column) : -1;
  };
  const auto keep = [&](std::size_t i, TexelOrigin tile) {
    const int place = place_of(tile);
    if (place < 0 || place_taken[static_cast<std::size_t>(place)] || slot_kept[i]) return;
    place_taken[static_cast<std::size_t>(place)] = slot_kept[i] = true;
    if (slots[i].target == tile && slots[i].has_target) return;
    slots[i].target = tile;
    slots[i].has_target = true;
    slots[i].failed = false;
    slots[i].ticket = next_ticket_++;
  };
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (slots[i].is_shown) keep(i, slots[i].shown);
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (slots[i].has_target) keep(i, slots[i].target);

  int place = 0;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (slot_kept[i]) continue;
    while (place_taken[static_cast<std::size_t>(place)]) ++place;
    slots[i].target = {moved.x + place % n * level.tile_texels(), moved.y + place / n * level.tile_texels()};
    slots[i].has_target = true;
    slots[i].failed = false;
    slots[i].ticket = next_ticket_++;
    ++place;
  }
  return true;
}

void Residency::swap(int slot_index, Ticket ticket) {
  Slot& slot = slots_[static_cast<std::size_t>(slot_index)];
  assert(slot.ticket == ticket);
  (void)ticket;
  slot.front = 1 - slot.front;
  slot.shown = slot.target;
  slot.is_shown = true;
  refresh(slot.level);
}

void Residency::mark_failed(int slot_index, Ticket ticket) {
  Slot& slot = slots_[static_cast<std::size_t>(slot_index)];
  if (slot.ticket == ticket) slot.failed = true;
}

void Residency::forget_content() {
  for (Slot& slot : slots_) {
    slot.is_shown = false;
    slot.failed = false;
    slot.ticket = next_ticket_++;
  }
  for (std::size_t i = 0; i < levels_.size(); ++i) refresh(static_cast<int>(i));
}

int Residency::waiting() const {
  int count = 0;
  for (const Slot& slot : slots_) count += slot.wants_load() ? 1 : 0;
  return count;
}

void Residency::refresh(int level_index) {
  const auto index = static_cast<std::size_t>(level_index);
  const LevelLayout& level = layout_.levels[index];
  SelectableLevel& selectable = levels_[index];
  selectable.any_shown = false;
  for (const SelectableTile& entry : selectable.tiles) {
    SelectableTile& tile = tiles_[static_cast<std::size_t>(entry.slot)];
    const Slot& slot = slots_[static_cast<std::size_t>(entry.slot)];
    tile.shown = slot.is_shown;
    if (!slot.is_shown) continue;
    tile.box = box_at(layout_, level.level, slot.shown, level.tile_texels());
    selectable.box = selectable.any_shown ? union_of(selectable.box, tile.box) : tile.box;
    selectable.any_shown = true;
  }
}

}  // namespace vt::runtime
