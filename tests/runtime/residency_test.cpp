#include "runtime/residency.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/runtime/test_store.h"

namespace vt::runtime {
namespace {

VtLayout layout_of(int tiles_per_side, int finest = 8) {
  const LayerInfo layer = test::layer_info({.tile_exponent = 6, .finest = finest, .data = {}, .paint = {}, .skip = {}}, {});
  return make_layout(layer, {.tile_exponent = 6, .tiles_per_side = tiles_per_side, .overrides = {}}).value();
}

void load_all(Residency& residency) {
  for (std::size_t i = 0; i < residency.slots().size(); ++i)
    if (residency.slots()[i].wants_load()) residency.swap(static_cast<int>(i), residency.slots()[i].ticket);
}

TEST(Residency, TargetsAreAlwaysExactlyTheTilesAroundTheCenter) {
  for (int n = 1; n <= 8; ++n) {
    Residency residency(layout_of(n));
    std::mt19937 random(31);
    std::uniform_real_distribution<double> anywhere(0.0, 1.0);
    for (int move = 0; move < 200; ++move) {
      const double s = anywhere(random);
      const double t = anywhere(random);
      for (std::size_t l = 0; l < residency.layout().levels.size(); ++l) residency.center_level(static_cast<int>(l), s, t);
      if (random() % 3 == 0) load_all(residency);
      for (std::size_t l = 0; l < residency.layout().levels.size(); ++l) {
        const LevelLayout& level = residency.layout().levels[l];
        const TexelOrigin box = residency.level_origin(static_cast<int>(l));
        std::set<std::pair<std::int64_t, std::int64_t>> places;
        for (const Slot& slot : residency.slots()) {
          if (slot.level != static_cast<int>(l)) continue;
          EXPECT_GE(slot.target.x, box.x);
          EXPECT_GE(slot.target.y, box.y);
          EXPECT_LE(slot.target.x + level.tile_texels(), box.x + level.box_texels());
          EXPECT_LE(slot.target.y + level.tile_texels(), box.y + level.box_texels());
          places.insert({slot.target.x, slot.target.y});
        }
        EXPECT_EQ(places.size(), static_cast<std::size_t>(level.tiles_per_side * level.tiles_per_side));
      }
    }
  }
}

TEST(Residency, TilesThatStayInTheBoxAreNotLoadedAgain) {
  Residency residency(layout_of(4));
  residency.center_level(0, 0.5, 0.5);
  load_all(residency);
  // One tile to the east: one column of four is new.
  const double tile = 1.0 / 256;
  residency.center_level(0, 0.5 + 1.3 * tile, 0.5);
  EXPECT_EQ(residency.waiting(), 4);
  load_all(residency);
  // And back, diagonal: a column and a row, less their common tile.
  residency.center_level(0, 0.5, 0.5 + 1.3 * tile);
  EXPECT_EQ(residency.waiting(), 7);
}

TEST(Residency, TheOldTileIsShownUntilTheNewOneIsComplete) {
  Residency residency(layout_of(1));
  residency.center_level(0, 0.25, 0.25);
  load_all(residency);
  const Box before = residency.selectable()[0].tiles[0].box;
  residency.center_level(0, 0.75, 0.75);
  EXPECT_TRUE(residency.selectable()[0].tiles[0].shown);
  EXPECT_EQ(residency.selectable()[0].tiles[0].box, before);
  load_all(residency);
  EXPECT_NE(residency.selectable()[0].tiles[0].box, before);
}

TEST(Residency, SwapExchangesFrontAndBack) {
  Residency residency(layout_of(1));
  residency.center_level(0, 0.5, 0.5);
  const int front = residency.slot(0).front;
  residency.swap(0, residency.slot(0).ticket);
  EXPECT_NE(residency.slot(0).front, front);
}

TEST(Residency, AFailedTileIsTriedAgainOnlyAfterTheCenterMoved) {
  Residency residency(layout_of(1));
  residency.center_level(0, 0.25, 0.25);
  residency.mark_failed(0, residency.slot(0).ticket);
  EXPECT_FALSE(residency.slot(0).wants_load());
  EXPECT_FALSE(residency.center_level(0, 0.25, 0.25));
  EXPECT_FALSE(residency.slot(0).wants_load());
  residency.center_level(0, 0.75, 0.25);
  EXPECT_TRUE(residency.slot(0).wants_load());
}

TEST(Residency, GoingBackToWhatIsStillShownNeedsNoLoad) {
  Residency residency(layout_of(1));
  residency.center_level(0, 0.25, 0.25);
  load_all(residency);
  residency.center_level(0, 0.75, 0.25);
  EXPECT_TRUE(residency.slot(0).wants_load());
  const Ticket stale = residency.slot(0).ticket;
  residency.center_level(0, 0.25, 0.25);
  EXPECT_FALSE(residency.slot(0).wants_load());
  EXPECT_NE(residency.slot(0).ticket, stale) << "what was on its way must not be shown";
}

}  // namespace
}  // namespace vt::runtime
