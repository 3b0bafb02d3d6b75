// Whole pyramids out of PlaneCascade, tier by tier and block by block, as the pipeline makes them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "builder/pyramid/plane_cascade.h"
#include "tests/support/whole_image.h"

namespace vt::pyramid {

using Levels = std::vector<test::WholeImage>;  // the finest first

// Levels up to the one of a single texel.
inline int levels_of(const LayerShape& layer) {
  int depth = 0;
  while (layer.data_at(depth).width > 1 || layer.data_at(depth).height > 1) ++depth;
  return depth + 1;
}

inline Levels levels_by_definition(const test::WholeImage& base, const HalvingKernel& kernel, const test::PlaneRules& rules) {
  Levels levels{base};
  while (static_cast<int>(levels.size()) < levels_of(base.layer)) levels.push_back(test::halve_whole(levels.back(), kernel, rules));
  return levels;
}

// Collects what blocks give out, and checks that every texel comes once.
class Collector final : public RowSink {
 public:
  // `truth`: the neighbours of every row have to be those of these levels; null: they are not looked at.
  Collector(Levels& levels, const Levels* truth, const test::PlaneRules& rules) : levels_(levels), truth_(truth), rules_(rules) {}
  void begin_block(const PlaneCascade& cascade) { cascade_ = &cascade; }

  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    const BlockLevel& level = cascade_->level(k);
    ASSERT_TRUE(y >= level.core.y && y < level.core.bottom());
    test::WholeImage& image = levels_[static_cast<std::size_t>(level.depth)];
    for (std::int64_t i = 0; i < level.core.width; ++i)
      for (int p = 0; p < image.planes; ++p) {
        float& texel = image.at(level.core.x + i, y, p);
        ASSERT_TRUE(std::isnan(texel)) << "given twice";
        texel = rows.here[static_cast<std::size_t>(p)][i];
        if (rows.opaque && p == rules_.weight_plane) {
          ASSERT_EQ(texel, 1.0F);
        }
      }
    if (truth_ != nullptr) check_neighbours((*truth_)[static_cast<std::size_t>(level.depth)], y, rows, level.core);
  }

 private:
  // Rows above and below, and one texel to either side.
  void check_neighbours(const test::WholeImage& truth, std::int64_t y, const channels::RowNeighbourhood& rows,
                        const TexelRect& core) const {
    for (std::int64_t i = -1; i <= core.width; ++i)
      for (int p = 0; p < truth.planes; ++p) {
        const auto plane = static_cast<std::size_t>(p);
        ASSERT_EQ(rows.above[plane][i], truth.seen(core.x + i, y - 1, p, rules_));
        ASSERT_EQ(rows.here[plane][i], truth.seen(core.x + i, y, p, rules_));
        ASSERT_EQ(rows.below[plane][i], truth.seen(core.x + i, y + 1, p, rules_));
      }
  }

  Levels& levels_;
  const Levels* truth_;
  const test::PlaneRules& rules_;
  const PlaneCascade* cascade_ = nullptr;
};

struct PyramidRun {
  const test::WholeImage& base;
  const HalvingKernel& kernel;
  const test::PlaneRules& rules;
  std::optional<channels::CentreRange> centre_range = {};
  int tile_exponent = 3;
  int levels_at_once = 3;         // of each tier
  const Levels* truth = nullptr;  // of the neighbours
};

// All levels. Where there is carry, it is the only thing that goes from tier to tier.
inline Levels levels_by_cascade(const PyramidRun& run) {
  const LayerShape& layer = run.base.layer;
  Levels levels;
  for (int depth = 0; depth < levels_of(layer); ++depth) {
    levels.emplace_back(layer, depth, run.base.planes);
    std::ranges::fill(levels.back().floats, std::numeric_limits<float>::quiet_NaN());
  }
  Collector collector(levels, run.truth, run.rules);
  using TileMap = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::byte>>;  // by column and row
  TileMap carry;
  for (int depth = 0; depth < levels_of(layer);) {
    const int left = levels_of(layer) - depth;
    const int outputs = std::min(run.levels_at_once, left);
    const bool with_carry = outputs < left;
    const std::int64_t block = std::int64_t{1} << (run.tile_exponent + outputs);
    const TexelRect data = layer.data_at(depth);
    TileMap next;
    for (std::int64_t by = data.y / block; by * block < data.bottom(); ++by)
      for (std::int64_t bx = data.x / block; bx * block < data.right(); ++bx) {
        PlaneCascade cascade(plan_block({bx * block, by * block, block, block}, layer, depth, outputs, with_carry, run.kernel), layer,
                             outputs, {run.rules.rules, run.rules.weight_plane, run.centre_range}, run.kernel, run.tile_exponent);
        collector.begin_block(cascade);
        const BlockLevel& base = cascade.level(0);
        if (depth == 0) {
          for (std::int64_t y = base.active.y; y < base.active.bottom(); ++y) {
            const channels::PlaneRow row = cascade.begin_row();
            bool opaque = true;
            for (std::int64_t x = 0; x < base.active.width; ++x) {
              for (int p = 0; p < run.base.planes; ++p)
                row[static_cast<std::size_t>(p)][x] = run.base.seen(base.active.x + x, y, p, run.rules);
              opaque = opaque && row[static_cast<std::size_t>(run.rules.weight_plane)][x] == 1.0F;
            }
            cascade.end_row(opaque, collector);
          }
        } else {
          const std::vector<std::int64_t> columns = carry_columns(base, run.tile_exponent);
          for (std::int64_t row = base.active.y >> run.tile_exponent; row <= (base.active.bottom() - 1) >> run.tile_exponent; ++row) {
            std::vector<std::vector<std::byte>> tiles;
            for (const std::int64_t column : columns) tiles.push_back(carry.at({column, row}));
            const auto fed = cascade.feed_carry({.row = row, .columns = columns, .tiles = tiles}, collector);
            EXPECT_TRUE(fed.has_value()) << fed.error().message;
          }
        }
        if (with_carry) cascade.carry_bytes(next[{bx, by}]);
      }
    carry = std::move(next);
    depth += outputs;
  }
  return levels;
}

}  // namespace vt::pyramid
