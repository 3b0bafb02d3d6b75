#include "builder/pipeline/blocks/block_marks.h"

#include <gtest/gtest.h>

namespace vt::pipeline {
namespace {

// A reader that draws the marks beside the texture sees each block's mark over the block, also when the data
// begin inside a block.
TEST(BlockMarks, LieOnTheGroundWhereTheirBlocksLie) {
  LayerPlan plan;
  plan.info.name = "color";
  plan.info.tile_exponent = 5;
  plan.info.finest = Level{5};
  plan.info.data = {70, 300, 500, 400};
  plan.info.grid = {.origin_x = 1000.0, .origin_y = 9000.0, .step_x = 2.0, .step_y = 0.5};
  for (const int block_levels : {1, 2, 3}) {
    const LayerInfo marks = BlockMarks::describe(plan, block_levels);
    const Tier first = plan_tiers(plan.info, block_levels).front();
    const std::int64_t edge = marks.tile_texels();
    for (std::int64_t index = 0; index < first.blocks(); ++index) {
      const TexelRect block = first.block(index);
      const TileId tile = first.carry_tile(index);
      EXPECT_EQ(tile.level, marks.finest);
      const double west = marks.grid.origin_x + static_cast<double>(tile.x * edge - marks.data.x) * marks.grid.step_x;
      const double north = marks.grid.origin_y - static_cast<double>(tile.y * edge - marks.data.y) * marks.grid.step_y;
      EXPECT_EQ(west, 1000.0 + static_cast<double>(block.x - 70) * 2.0) << "block levels " << block_levels << ", block " << index;
      EXPECT_EQ(north, 9000.0 - static_cast<double>(block.y - 300) * 0.5) << "block levels " << block_levels << ", block " << index;
    }
  }
}

}  // namespace
}  // namespace vt::pipeline
