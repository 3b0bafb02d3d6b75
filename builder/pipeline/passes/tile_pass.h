// What passes over the finished tiles of a layer share: visiting the tiles of a level on all threads, and
// reading their values.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "builder/pipeline/parallel/parallel.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// `tile_row` counts the rows of tiles with data from 0, north to south.
using TileUse = std::function<Result<void>(std::size_t tile_row, const TileId& tile)>;

// Calls use() for every place of a tile in the data of a level, there or not. Rows of tiles go to up to
// `threads` threads, each row from west to east on one of them. kCancelled as soon as `cancel` (which may be
// null) is seen; otherwise the first error of `use`.
[[nodiscard]] Result<void> for_each_tile(const LayerInfo& layer, Level level, int threads, const std::atomic<bool>* cancel,
                                         const TileUse& use);

// The samples of a tile as store::decode_texels() gives them, row by row; false: the tile is absent,
// `samples` is empty.
[[nodiscard]] Result<bool> read_samples(const store::StoreWriter& writer, const LayerInfo& layer, LayerId id, const TileId& tile,
                                        std::vector<float>& samples);

}  // namespace vt::pipeline
