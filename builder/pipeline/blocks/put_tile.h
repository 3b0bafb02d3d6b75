// One finished tile into the store, and what became of it.
#pragma once

#include <cstdint>

#include "builder/encode/tile_band.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// What became of the tiles of some blocks. Tiles of the carry are not counted.
struct TileCounts {
  std::int64_t written = 0;
  std::int64_t unchanged = 0;  // were in the store already, byte for byte
  std::int64_t removed = 0;    // were in the store and have no data any more

  TileCounts& operator+=(const TileCounts& other) {
    written += other.written;
    unchanged += other.unchanged;
    removed += other.removed;
    return *this;
  }
};

// Writes the tile, or removes what an empty one leaves behind; a tile that is there byte for byte costs
// nothing. Counts in `counts`. Errors and threads as StoreWriter.
[[nodiscard]] Result<void> put_tile(store::StoreWriter& writer, LayerId layer, const encode::EncodedTile& tile, TileCounts& counts);

}  // namespace vt::pipeline
