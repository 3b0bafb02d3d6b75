#include "runtime/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace vt::runtime {
namespace {

// A world of tiles on a 64 x 64 lattice, so that the truth about coverage is a set of bits.
constexpr int kLattice = 64;
using Bits = std::array<std::uint64_t, kLattice>;

struct Cells {
  int x0, y0, x1, y1;
};

Bits bits_of(const Cells& c) {
  Bits bits{};
  const int x0 = std::clamp(c.x0, 0, kLattice);
  const int x1 = std::clamp(c.x1, 0, kLattice);
  if (x0 >= x1) return bits;
  const std::uint64_t row = (x1 - x0 == 64 ? ~std::uint64_t{0} : ((std::uint64_t{1} << (x1 - x0)) - 1)) << x0;
  for (int y = std::max(c.y0, 0); y < std::min(c.y1, kLattice); ++y) bits[static_cast<std::size_t>(y)] = row;
  return bits;
}

Box box_of(const Cells& c) { return {c.x0 / 64.0, c.y0 / 64.0, c.x1 / 64.0, c.y1 / 64.0}; }

struct World {
  std::vector<std::vector<Cells>> cells;  // by level, finest first
  std::vector<std::vector<SelectableTile>> tiles;
  std::vector<SelectableLevel> levels;
};

World make_world(const std::vector<std::vector<Cells>>& cells, std::mt19937* hide = nullptr) {
  World world;
  world.cells = cells;
  int slot = 0;
  for (const auto& level : cells) {
    world.tiles.emplace_back();
    for (const Cells& c : level)
      world.tiles.back().push_back(
          {.box = box_of(c), .shown = hide == nullptr || &level == &cells.back() || (*hide)() % 8 != 0, .slot = slot++});
  }
  for (const auto& tiles : world.tiles) {
    SelectableLevel level{.box = {}, .any_shown = false, .tolerance = 1e-9, .tiles = tiles};
    for (const SelectableTile& tile : tiles) {
      if (!tile.shown) continue;
      level.box = level.any_shown ? union_of(level.box, tile.box) : tile.box;
      level.any_shown = true;
    }
    world.levels.push_back(level);
  }
  return world;
}

World random_world(std::mt19937& random) {
  std::vector<std::vector<Cells>> cells;
  for (int size = 4; size <= 32; size *= 2) {
    const int n = 1 + static_cast<int>(random() % 3);
    const int hop = size / 2;
    const int x = static_cast<int>(random() % static_cast<unsigned>(kLattice / hop)) * hop - hop;
    const int y = static_cast<int>(random() % static_cast<unsigned>(kLattice / hop)) * hop - hop;
    cells.emplace_back();
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) cells.back().push_back({x + i * size, y + j * size, x + (i + 1) * size, y + (j + 1) * size});
  }
  cells.push_back({{0, 0, kLattice, kLattice}});
  return make_world(cells, &random);
}

Cells random_box(std::mt19937& random) {
  const int w = 1 + static_cast<int>(random() % (random() % 4 == 0 ? 40 : 9));
  const int h = 1 + static_cast<int>(random() % (random() % 4 == 0 ? 40 : 9));
  const int x = static_cast<int>(random() % static_cast<unsigned>(kLattice - w + 1));
  const int y = static_cast<int>(random() % static_cast<unsigned>(kLattice - h + 1));
  return {x, y, x + w, y + h};
}

bool contains(const Cells& a, const Cells& b) { return a.x0 <= b.x0 && a.y0 <= b.y0 && a.x1 >= b.x1 && a.y1 >= b.y1; }

// The definitions, with integers and bits and no culling.
int brute_one(const World& world, const Cells& box, std::size_t* level = nullptr) {
  for (std::size_t l = 0; l < world.cells.size(); ++l)
    for (std::size_t i = 0; i < world.cells[l].size(); ++i)
      if (world.tiles[l][i].shown && contains(world.cells[l][i], box)) {
        if (level != nullptr) *level = l;
        return world.tiles[l][i].slot;
      }
  return -1;
}

std::vector<int> brute_stages(const World& world, const Cells& box, int cap) {
  std::size_t single_level = 0;
  const int single = brute_one(world, box, &single_level);
  Bits open = bits_of(box);
  std::vector<int> chosen;
  for (std::size_t l = 0; l < single_level; ++l)
    for (std::size_t i = 0; i < world.cells[l].size(); ++i) {
      if (!world.tiles[l][i].shown) continue;
      const Bits tile = bits_of(world.cells[l][i]);
      bool adds = false;
      for (std::size_t y = 0; y < kLattice; ++y) adds = adds || (open[y] & tile[y]) != 0;
      if (!adds) continue;
      chosen.push_back(world.tiles[l][i].slot);
      bool left = false;
      for (std::size_t y = 0; y < kLattice; ++y) {
        open[y] &= ~tile[y];
        left = left || open[y] != 0;
      }
      if (static_cast<int>(chosen.size()) <= cap && !left) return chosen;
    }
  chosen.resize(std::min<std::size_t>(chosen.size(), static_cast<std::size_t>(cap - 1)));
  chosen.push_back(single);
  return chosen;
}

std::vector<int> slots_of(const StageSet& set) { return {set.slots.begin(), set.slots.begin() + set.count}; }

TEST(Selection, OneTileEqualsBruteForceOnAMillionBoxes) {
  std::mt19937 random(11);
  for (int w = 0; w < 1000; ++w) {
    const World world = random_world(random);
    for (int trial = 0; trial < 1000; ++trial) {
      const Cells box = random_box(random);
      const StageSet set = select_one(world.levels, box_of(box));
      ASSERT_EQ(set.count, 1);
      ASSERT_EQ(set.slots[0], brute_one(world, box));
      ASSERT_TRUE(set.covers);
    }
  }
}

TEST(Selection, StagesEqualBruteForceOnAMillionBoxesAndNeverLeaveAHole) {
  std::mt19937 random(12);
  std::uint64_t stages = 0;
  for (int w = 0; w < 1000; ++w) {
    const World world = random_world(random);
    std::vector<Bits> bits;
    for (const auto& level : world.cells)
      for (const Cells& c : level) bits.push_back(bits_of(c));
    for (int trial = 0; trial < 1000; ++trial) {
      const Cells box = random_box(random);
      const int cap = 1 + static_cast<int>(random() % 8);
      const StageSet set = select_stages(world.levels, box_of(box), cap);
      ASSERT_EQ(slots_of(set), brute_stages(world, box, cap)) << "cap " << cap;
      ASSERT_LE(set.count, cap);
      ASSERT_TRUE(set.covers);
      // Every cell of the box is under one of the tiles.
      Bits open = bits_of(box);
      for (const int slot : slots_of(set))
        for (std::size_t y = 0; y < kLattice; ++y) open[y] &= ~bits[static_cast<std::size_t>(slot)][y];
      ASSERT_EQ(open, Bits{});
      stages += static_cast<std::uint64_t>(set.count);
    }
  }
  RecordProperty("mean_stages", std::to_string(static_cast<double>(stages) / 1e6));
}

// Figure 3 of the paper.
TEST(Selection, Figure3aATileThatOnlyOverlapsTheGeometryIsNotUsed) {
  const World world = make_world({{{10, 10, 26, 26}}, {{0, 0, 64, 64}}});
  EXPECT_EQ(slots_of(select_one(world.levels, box_of({20, 20, 30, 30}))), std::vector<int>{1});
  EXPECT_EQ(slots_of(select_stages(world.levels, box_of({20, 20, 30, 30}), 2)), (std::vector<int>{0, 1}));
}

TEST(Selection, Figure3bATileCenteredOnTheGeometryIsUsed) {
  const World world = make_world({{{17, 17, 33, 33}}, {{0, 0, 64, 64}}});
  EXPECT_EQ(slots_of(select_one(world.levels, box_of({20, 20, 30, 30}))), std::vector<int>{0});
  EXPECT_EQ(slots_of(select_stages(world.levels, box_of({20, 20, 30, 30}), 4)), std::vector<int>{0});
}

TEST(Selection, Figure3cFourTilesCoverTogetherWhatNoneCoversAlone) {
  const World world = make_world({{{8, 8, 24, 24}, {24, 8, 40, 24}, {8, 24, 24, 40}, {24, 24, 40, 40}}, {{0, 0, 64, 64}}});
  const Box box = box_of({20, 20, 30, 30});
  EXPECT_EQ(slots_of(select_one(world.levels, box)), std::vector<int>{4});
  EXPECT_EQ(slots_of(select_stages(world.levels, box, 4)), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(slots_of(select_stages(world.levels, box, 3)), (std::vector<int>{0, 1, 4})) << "one stage less: the coarse tile closes the gap";
  EXPECT_EQ(slots_of(select_stages(world.levels, box, 1)), std::vector<int>{4});
}

TEST(Selection, OutsideEverythingTheCoarsestTileIsTheLastResort) {
  const World world = make_world({{{10, 10, 26, 26}}, {{0, 0, 64, 64}}});
  const StageSet one = select_one(world.levels, {0.9, 0.9, 1.2, 1.1});
  EXPECT_EQ(slots_of(one), std::vector<int>{1});
  EXPECT_FALSE(one.covers);
  const StageSet stages = select_stages(world.levels, {0.1, 0.1, 1.2, 1.1}, 4);
  EXPECT_EQ(slots_of(stages), (std::vector<int>{0, 1}));
  EXPECT_FALSE(stages.covers);
}

TEST(Selection, NothingIsSelectedWhileNothingIsLoaded) {
  World world = make_world({{{0, 0, 64, 64}}});
  world.tiles[0][0].shown = false;
  world.levels[0].any_shown = false;
  EXPECT_EQ(select_one(world.levels, {0, 0, 1, 1}).count, 0);
  EXPECT_EQ(select_stages(world.levels, {0, 0, 1, 1}, 4).count, 0);
}

TEST(Selection, LinesAndPointsAreGeometryToo) {
  const World world = make_world({{{16, 16, 32, 32}, {32, 16, 48, 32}}, {{0, 0, 64, 64}}});
  EXPECT_EQ(slots_of(select_one(world.levels, {0.3, 0.3, 0.3, 0.3})), std::vector<int>{0});
  EXPECT_EQ(slots_of(select_stages(world.levels, {0.3, 0.3, 0.6, 0.3}, 4)), (std::vector<int>{0, 1}));
  EXPECT_EQ(slots_of(select_stages(world.levels, {0.3, 0.3, 0.9, 0.3}, 4)), (std::vector<int>{0, 1, 2}));
}

TEST(SortByTile, DrawsThatShareTilesFollowOneAnother) {
  std::mt19937 random(13);
  std::vector<StageSet> draws(500);
  for (StageSet& set : draws) {
    set.count = 1 + static_cast<int>(random() % 3);
    for (int i = 0; i < set.count; ++i) set.slots[static_cast<std::size_t>(i)] = static_cast<int>(random() % 3);
  }
  std::vector<std::uint32_t> order(draws.size());
  sort_by_tile(draws, order);
  std::vector<std::vector<int>> runs;
  for (const std::uint32_t i : order)
    if (runs.empty() || runs.back() != slots_of(draws[i])) runs.push_back(slots_of(draws[i]));
  std::vector<std::vector<int>> distinct = runs;
  std::sort(distinct.begin(), distinct.end());
  EXPECT_EQ(std::unique(distinct.begin(), distinct.end()), distinct.end()) << "a set of tiles comes in two runs";
}

}  // namespace
}  // namespace vt::runtime
