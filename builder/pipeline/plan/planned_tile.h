// Tiles of the finest level as a plan's sources give them, without a store: what a build would write there,
// and the planes that it comes from. For programs that hold rasters beside a layer that was built. One object
// per thread; the plan outlives it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pipeline/plan/wrapped_chunk.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::pipeline {

struct PlannedTile {
  TexelRect rect;                  // texels of the tile that lie inside the data, in the padded square
  bool is_empty = true;            // no texel has data: nothing is stored
  std::vector<std::byte> payload;  // otherwise: as decompressed from the store, texels or blocks
  // Texels of `rect`, row by row, that hold a value which the layer's format cannot. A build stops there;
  // here their payload is 0.
  std::vector<std::uint8_t> misfits;  // empty: none does
  std::string misfit;                 // the first of them, in words
  std::vector<float> planes;          // of `rect`: for each row, all planes one after the other
};

class PlannedTiles {
 public:
  // `part` counts in plan.parts. The plan has sources.
  PlannedTiles(const LayerPlan& plan, std::size_t part);

  // `tile` is one of plan.info.tile_rect(finest).
  [[nodiscard]] Result<void> make(TileId tile, PlannedTile& out);

 private:
  class Sink;
  const LayerPlan& plan_;
  std::size_t part_;
  WrappedChunk chunk_;
};

}  // namespace vt::pipeline
