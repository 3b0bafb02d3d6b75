#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <memory>

#include "builder/sample/bands.h"

namespace vt::sample {
namespace {

// The whole scene in one band of memory.
Band whole_scene(std::uint64_t seed, std::int64_t size) {
  const World world(seed);
  Band all;
  Band band;
  for (std::int64_t i = 0; i < band_count(size); ++i) {
    paint_band(world, size, i, band);
    all.rows += band.rows;
    all.rgb.insert(all.rgb.end(), band.rgb.begin(), band.rgb.end());
    all.material.insert(all.material.end(), band.material.begin(), band.material.end());
    all.height_m.insert(all.height_m.end(), band.height_m.begin(), band.height_m.end());
  }
  return all;
}

constexpr std::int64_t kSize = 2048;
const Band& scene() {
  static const Band all = whole_scene(1, kSize);
  return all;
}

bool same(const Band& a, const Band& b) { return a.rgb == b.rgb && a.material == b.material && a.height_m == b.height_m; }

TEST(SampleBands, SameBytesWithOneThreadAndWithTwo) {
  Band one, two;
  tbb::task_arena(1).execute([&] { one = whole_scene(7, 1024); });
  tbb::task_arena(2).execute([&] { two = whole_scene(7, 1024); });
  EXPECT_TRUE(same(one, two));
  EXPECT_FALSE(same(one, whole_scene(8, 1024))) << "the seed must matter";
}

// A square must not know where the squares are cut: a scene of another size, whose squares lie elsewhere,
// shows the same land.
TEST(SampleBands, SmallerSceneIsTheMiddleOfTheLarger) {
  constexpr std::int64_t kInner = 1304;  // not a multiple of 256, so that all seams move
  const Band inner = whole_scene(1, kInner);
  const std::int64_t offset = (kSize - kInner) / 2;
  for (std::int64_t y = 0; y < kInner; ++y) {
    const auto row = inner.rgb.begin() + y * kInner * 3;
    ASSERT_TRUE(std::equal(row, row + kInner * 3, scene().rgb.begin() + ((y + offset) * kSize + offset) * 3)) << "row " << y;
  }
  for (std::int64_t y = 0; y < kInner / 4; ++y) {
    const auto row = inner.height_m.begin() + y * (kInner / 4);
    ASSERT_TRUE(std::equal(row, row + kInner / 4, scene().height_m.begin() + (y + offset / 4) * (kSize / 4) + offset / 4)) << "row " << y;
  }
}

TEST(SampleBands, SmallScenesWork) {
  for (const std::int64_t size : {16, 64, 264}) {
    const Band band = whole_scene(1, size);
    EXPECT_EQ(band.rows, size);
    EXPECT_EQ(band.rgb.size(), static_cast<std::size_t>(size * size * 3));
    EXPECT_EQ(band.material.size(), static_cast<std::size_t>(size * size / 4));
    EXPECT_EQ(band.height_m.size(), static_cast<std::size_t>(size * size / 16));
    for (const std::uint8_t code : band.material) ASSERT_TRUE(code >= 1 && code <= 9);
  }
}

TEST(SampleBands, EveryClassButSnowIsInTheMiddleAndSnowOnTheHeights) {
  std::map<int, std::size_t> counts;
  for (const std::uint8_t code : scene().material) ++counts[code];
  for (int code = 1; code <= 9; ++code) {
    if (code != static_cast<int>(Material::kSnow)) {
      EXPECT_GT(counts[code], scene().material.size() / 2000) << "class " << code;
    }
  }
  // Somewhere in the mountains of the 4096 scene.
  const World world(1);
  Painter painter(world);
  const auto square = std::make_unique<Square>();
  std::size_t snow = 0;
  for (std::int64_t row = -2048; row < 0; row += 512) {
    painter.paint(2048 - kSquare, row, *square);
    snow += static_cast<std::size_t>(std::count(square->material.begin(), square->material.end(), Material::kSnow));
  }
  EXPECT_GT(snow, 0U);
}

// The four materials texels under an elevation texel.
std::array<std::uint8_t, 4> materials_under(std::int64_t x, std::int64_t y) {
  const std::int64_t width = kSize / 2;
  const auto at = static_cast<std::size_t>(y * 2 * width + x * 2);
  const auto& m = scene().material;
  return {m[at], m[at + 1], m[at + static_cast<std::size_t>(width)], m[at + static_cast<std::size_t>(width) + 1]};
}

TEST(SampleBands, WaterIsWhereTheLandLiesBelowIt) {
  const World world(1);
  std::size_t sea = 0, river = 0, dry = 0;
  for (std::int64_t y = 1; y + 1 < kSize / 4; ++y) {
    for (std::int64_t x = 1; x + 1 < kSize / 4; ++x) {
      // Ask the world at this texel and its neighbours; near a shore the layers may differ by their
      // resolution.
      bool all_wet = true, all_dry = true;
      Ground here{};
      for (const auto& [dx, dy] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}}) {
        const Position p{(static_cast<double>(x + dx) + 0.5) * 2.0 - kSize * 0.25,
                         kSize * 0.25 - (static_cast<double>(y + dy) + 0.5) * 2.0};
        const Ground g = world.ground(p);
        if (dx == 0 && dy == 0) here = g;
        (g.dry_m < 0.0F || g.river_m < 0.0F ? all_dry : all_wet) = false;
      }
      const float height = scene().height_m[static_cast<std::size_t>(y * (kSize / 4) + x)];
      if (height != kVoid) {
        ASSERT_EQ(height, here.height_m);
        ASSERT_GE(height, 0.0F);
      }
      for (const std::uint8_t code : materials_under(x, y)) {
        const bool water = code == static_cast<std::uint8_t>(Material::kWater);
        if (all_dry) {
          ASSERT_FALSE(water) << x << " " << y;
          ++dry;
        }
        // Roads bridge rivers, and crowns of trees reach over their banks.
        if (all_wet && here.river_m > 0.0F) {
          ASSERT_TRUE(water) << x << " " << y;
          ASSERT_EQ(height, 0.0F);
          ++sea;
        }
        if (all_wet && here.river_m < -6.0F && here.coast_road_m > 8.0F && here.valley_road_m > 8.0F) {
          ASSERT_TRUE(water) << x << " " << y;
          ++river;
        }
      }
    }
  }
  EXPECT_GT(sea, 10000U);
  EXPECT_GT(river, 1000U);
  EXPECT_GT(dry, 100000U);
}

TEST(SampleBands, ColorsTellTheClasses) {
  // Mean colour of each class: the sea is blue, vegetation green, snow and sand bright, roofs red.
  struct Sum {
    double r = 0, g = 0, b = 0, n = 0;
  };
  std::map<Material, Sum> sums;
  for (std::int64_t y = 0; y < kSize / 2; ++y) {
    for (std::int64_t x = 0; x < kSize / 2; ++x) {
      Sum& sum = sums[static_cast<Material>(scene().material[static_cast<std::size_t>(y * (kSize / 2) + x)])];
      const std::uint8_t* texel = &scene().rgb[static_cast<std::size_t>((y * 2 * kSize + x * 2) * 3)];
      sum.r += texel[0], sum.g += texel[1], sum.b += texel[2], sum.n += 1;
    }
  }
  const auto mean = [&](Material m) { return Sum{sums[m].r / sums[m].n, sums[m].g / sums[m].n, sums[m].b / sums[m].n, 1}; };
  const Sum water = mean(Material::kWater), sand = mean(Material::kSand), forest = mean(Material::kForest),
            roof = mean(Material::kBuilding), grass = mean(Material::kGrass), road = mean(Material::kRoad);
  EXPECT_GT(water.b, water.r + 20);
  EXPECT_GT(forest.g, forest.r);
  EXPECT_GT(forest.g, forest.b + 10);
  EXPECT_GT(grass.g, forest.g);
  EXPECT_GT(sand.r, 130);
  EXPECT_GT(sand.r, sand.b + 15);
  EXPECT_GT(roof.r, roof.b + 10);
  EXPECT_LT(std::abs(road.r - road.b), 20);
}

TEST(SampleBands, SunLightsTheSlopesThatFaceIt) {
  // Over open rock, grass and snow: texels on slopes that face north-west are brighter than those that turn
  // away.
  double lit = 0, lit_count = 0, turned = 0, turned_count = 0;
  const std::int64_t width = kSize / 4;
  for (std::int64_t y = 1; y + 1 < width; ++y) {
    for (std::int64_t x = 1; x + 1 < width; ++x) {
      const auto at = static_cast<std::size_t>(y * width + x);
      const auto code = static_cast<Material>(scene().material[static_cast<std::size_t>(y * 2 * (kSize / 2) + x * 2)]);
      if (code != Material::kRock) continue;
      const float east = scene().height_m[at + 1] - scene().height_m[at - 1];
      const float north = scene().height_m[at - static_cast<std::size_t>(width)] - scene().height_m[at + static_cast<std::size_t>(width)];
      const double brightness = scene().rgb[static_cast<std::size_t>((y * 4 * kSize + x * 4) * 3 + 1)];
      if (east > 1.0F && north < -1.0F) lit += brightness, lit_count += 1;
      if (east < -1.0F && north > 1.0F) turned += brightness, turned_count += 1;
    }
  }
  ASSERT_GT(lit_count, 20);
  ASSERT_GT(turned_count, 20);
  EXPECT_GT(lit / lit_count, turned / turned_count + 25.0);
}

TEST(SampleBands, VoidsAreFewAndSmall) {
  const Band band = whole_scene(1, 4096);
  const auto voids = std::count(band.height_m.begin(), band.height_m.end(), kVoid);
  EXPECT_GT(voids, 0);
  EXPECT_LT(static_cast<double>(voids), 0.005 * static_cast<double>(band.height_m.size()));
}

TEST(SampleLights, StandInsideAndOnTheGroundByRoadsAndHouses) {
  const World world(1);
  const std::vector<Light> lights = lights_of(world, kSize);
  EXPECT_GT(lights.size(), 200U);
  std::size_t near_works_of_man = 0;
  for (const Light& light : lights) {
    ASSERT_LE(std::abs(light.position.x), kSize * 0.25);
    ASSERT_LE(std::abs(light.position.y), kSize * 0.25);
    ASSERT_GT(light.height_m, 0.0F);
    ASSERT_GT(light.power_w, 0.0F);
    ASSERT_EQ(std::max({light.red, light.green, light.blue}), 1.0F);
    // A road or a building within 5 m on the materials raster.
    const auto x = static_cast<std::int64_t>(light.position.x + kSize * 0.25);
    const auto y = static_cast<std::int64_t>(kSize * 0.25 - light.position.y);
    bool found = false;
    for (std::int64_t j = std::max<std::int64_t>(0, y - 5); j <= std::min<std::int64_t>(kSize / 2 - 1, y + 5); ++j) {
      for (std::int64_t i = std::max<std::int64_t>(0, x - 5); i <= std::min<std::int64_t>(kSize / 2 - 1, x + 5); ++i) {
        const auto code = static_cast<Material>(scene().material[static_cast<std::size_t>(j * (kSize / 2) + i)]);
        found = found || code == Material::kRoad || code == Material::kBuilding;
      }
    }
    near_works_of_man += found ? 1U : 0U;
  }
  // Lamps in the middle of parks are the exception.
  EXPECT_GT(static_cast<double>(near_works_of_man), 0.95 * static_cast<double>(lights.size()));
}

}  // namespace
}  // namespace vt::sample
