#include "builder/pipeline/blocks/put_tile.h"

namespace vt::pipeline {

Result<void> put_tile(store::StoreWriter& writer, LayerId layer, const encode::EncodedTile& tile, TileCounts& counts) {
  if (tile.is_empty) {
    // A rebuilt block may find nothing where there was something.
    if (!writer.contains(layer, tile.tile)) return {};
    ++counts.removed;
    return writer.remove(layer, tile.tile);
  }
  // What a rebuilt block finds as it was costs no new bytes.
  const bool is_constant = !tile.constant_block.empty();
  VT_ASSIGN(const bool is_there,
            is_constant ? writer.holds_constant(layer, tile.tile, tile.constant_block) : writer.holds(layer, tile.tile, tile.payload));
  if (is_there) {
    ++counts.unchanged;
    return {};
  }
  ++counts.written;
  return is_constant ? writer.put_constant(layer, tile.tile, tile.constant_block) : writer.put(layer, tile.tile, tile.payload);
}

}  // namespace vt::pipeline
