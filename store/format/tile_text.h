// Small helpers that the writer, the reader and the validator share: how a tile is named in messages, how a
// constant becomes texels. Pure functions.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>

#include "store/layer.h"

namespace vt::store {

[[nodiscard]] inline std::string tile_place(const LayerInfo& layer, TileId tile) {
  return "layer " + layer.name + ", level " + std::to_string(tile.level.value) + ", tile " + std::to_string(tile.x) + "," +
         std::to_string(tile.y);
}

// What can be wrong with a tile in sentences that several files say.
inline constexpr const char* kParentIsAbsent = "its parent is absent, so readers coming from above never find it";
inline constexpr const char* kBlobIsShared = "a blob has a record of its own, and this one is shared";

// Repeats one block over `out`, whose length is a multiple of it.
inline void fill_constant(std::span<const std::byte> block, std::span<std::byte> out) {
  assert(!block.empty() && out.size() % block.size() == 0);
  if (out.empty()) return;
  std::memcpy(out.data(), block.data(), block.size());
  // What is filled doubles with every copy.
  for (std::size_t filled = block.size(); filled < out.size();) {
    const std::size_t more = std::min(filled, out.size() - filled);
    std::memcpy(out.data() + filled, out.data(), more);
    filled += more;
  }
}

}  // namespace vt::store
