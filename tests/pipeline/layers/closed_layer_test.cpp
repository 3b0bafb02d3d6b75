// Layers that close around the globe: past +180 degrees lies -180, at every level and for every kind of
// layer.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "builder/pipeline/plan/planned_tile.h"
#include "builder/pipeline/plan/work_map.h"
#include "tests/pipeline/layers/layer_kinds.h"
#include "tests/pipeline/level_values.h"

namespace vt::pipeline {
namespace {

bool is_closed(const RasterSpec& spec, const test::TempFolder& folder) {
  write_raster(folder / "input.tif", spec, [](std::int64_t, std::int64_t, int) { return 1.0; });
  const auto plan = plan_layer(request_for({folder / "input.tif"}, ChannelType::kColor), std::nullopt, std::size_t{1} << 20);
  EXPECT_TRUE(plan.has_value());
  return plan.has_value() && plan->is_closed;
}

TEST(ClosedLayer, IsOneThatSpansTheCircleToAThousandthOfATexel) {
  const test::TempFolder folder;
  EXPECT_TRUE(is_closed(around_the_globe(64, 16), folder));
  EXPECT_TRUE(is_closed(around_the_globe(37, 16), folder)) << "a step that is no binary fraction";
  RasterSpec spec = around_the_globe(64, 16);
  for (const auto& [columns, closes] : {std::pair{64, true}, std::pair{63, false}, std::pair{65, false}}) {
    spec.width = columns;
    EXPECT_EQ(is_closed(spec, folder), closes) << columns << " columns";
  }
  spec.width = 64;
  spec.transform.x0 = 0.0;
  EXPECT_TRUE(is_closed(spec, folder)) << "0 to 360";
  for (const auto& [texels, closes] :
       {std::pair{0.0005, true}, std::pair{0.002, false}, std::pair{-0.0005, true}, std::pair{-0.002, false}}) {
    spec.transform.x_column = 360.0 / (64.0 + texels);
    EXPECT_EQ(is_closed(spec, folder), closes) << texels << " texels off";
  }

  constexpr double kAround = 2.0 * std::numbers::pi * 6378137.0;
  RasterSpec mercator{
      .width = 64, .height = 64, .transform = {-kAround / 2, kAround / 64, 0.0, kAround / 2, 0.0, -kAround / 64}, .epsg = 3857};
  EXPECT_TRUE(is_closed(mercator, folder));
  mercator.width = 62;
  EXPECT_FALSE(is_closed(mercator, folder));
  // As many metres of a transverse Mercator grid are no circle.
  RasterSpec utm{.width = 64, .height = 64, .transform = {500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0}};
  EXPECT_FALSE(is_closed(utm, folder));
}

TEST(ClosedLayer, PixelsAreNeverClosed) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", around_the_globe(360, 16), noisy_code);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  request.sources[0].crs = request.crs = geo::Crs();
  const auto plan = plan_layer(request, std::nullopt, std::size_t{1} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  EXPECT_FALSE(plan->is_closed);
}

// What programs make again of a layer's sources to hold it beside them sees across the seam as the build did.
TEST(ClosedLayer, TilesThatArePlannedAgainAreThoseThatWereBuilt) {
  const test::TempFolder folder;
  int kinds = 0;
  for (const Case& c : cases()) {
    if (!c.name.starts_with("globe_")) continue;
    ++kinds;
    std::filesystem::remove(folder / "a.vts");
    write_raster(folder / "input.tif", c.raster, c.value);
    const LayerRequest request = request_of(c, folder / "input.tif");
    build(folder / "a.vts", request);
    const auto reader = store::StoreReader::open(folder / "a.vts");
    ASSERT_TRUE(reader.has_value());
    const LayerInfo* layer = reader->find_layer(request.name);
    ASSERT_NE(layer, nullptr);
    const auto plan = plan_layer(request, std::nullopt, {.existing = layer});
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    EXPECT_TRUE(plan->is_closed);
    const Tiles built = tiles_of(folder / "a.vts", layer->name);
    PlannedTiles planned(*plan, 0);
    const TexelRect tiles = layer->tile_rect(layer->finest);
    for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y)
      for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
        const TileId tile{layer->finest, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
        PlannedTile made;
        ASSERT_TRUE(planned.make(tile, made).has_value());
        const auto there = built.find(tile);
        ASSERT_EQ(made.is_empty, there == built.end()) << c.name << " " << x << "," << y;
        if (made.is_empty) continue;
        EXPECT_EQ(made.payload, there->second) << c.name << " " << x << "," << y;
      }
  }
  EXPECT_GT(kinds, 3);
}

// Where the seam lies decides nothing: a globe that is turned by half its columns has all levels of all its
// textures turned, to the bit.
TEST(ClosedLayer, TurningTheGlobeTurnsEveryLevelOfEveryKindOfLayer) {
  const test::TempFolder folder;
  for (Case c : cases()) {
    if (!c.name.starts_with("globe_")) continue;
    // 256 columns wrap at all of the four levels.
    c.raster.width = 256;
    c.raster.transform.x_column = 360.0 / 256;
    for (const bool turned : {false, true}) {
      const auto name = folder / (turned ? "turned" : "plain");
      const auto value = [&](std::int64_t x, std::int64_t y, int band) { return c.value(turned ? (x + 128) % 256 : x, y, band); };
      write_raster(name.string() + ".tif", c.raster, value);
      std::filesystem::remove(name.string() + ".vts");
      build(name.string() + ".vts", request_of(c, name.string() + ".tif"), {.threads = turned ? 2 : 1, .block_levels = turned ? 1 : 3});
    }
    const auto plain = store::StoreReader::open(folder / "plain.vts");
    const auto turned = store::StoreReader::open(folder / "turned.vts");
    ASSERT_TRUE(plain.has_value() && turned.has_value());
    for (const LayerInfo& layer : plain->layers()) {
      if (layer.role != LayerRole::kTexture) continue;
      ASSERT_EQ(layer.finest.value, 3);
      for (int value = 0; value <= 3; ++value) {
        const Level level{static_cast<std::uint8_t>(value)};
        const LevelValues here(*plain, layer, level);
        const LevelValues there(*turned, *turned->find_layer(layer.name), level);
        for (std::int64_t y = 0; y < here.height(); ++y)
          for (std::int64_t x = 0; x < here.width(); ++x)
            for (std::size_t component = 0; component < format_info(layer.format).channels; ++component) {
              const double wanted = here.at((x + here.width() / 2) % here.width(), y, component);
              const double found = there.at(x, y, component);
              ASSERT_TRUE(found == wanted || (std::isnan(found) && std::isnan(wanted)))
                  << c.name << ", " << layer.name << ", level " << value << ", texel " << x << ", " << y << ": " << found << " for "
                  << wanted;
            }
      }
    }
  }
}

TEST(ClosedLayer, ALineAtTheSeamIsSeenFromBothSides) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", around_the_globe(256, 64), [](std::int64_t x, std::int64_t, int) { return x >= 254 ? 250.0 : 5.0; });
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  build(folder / "a.vts", request);
  const auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LayerInfo& layer = *reader->find_layer("color");
  for (int steps = 1; steps <= layer.finest.value; ++steps) {
    const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(layer.finest.value - steps)});
    const std::int64_t count = values.width();
    // The line is two columns wide, so at level 1 it is one texel and both neighbours look alike.
    if (steps == 1) {
      EXPECT_EQ(values.at(0, 3), values.at(count - 2, 3));
    }
    EXPECT_GT(values.at(0, 3), values.at(count / 2, 3)) << steps << " levels up";
  }
}

// Colour that a clear texel borrows may come from across the seam, on the finest level too.
TEST(ClosedLayer, ClearTexelsBorrowColourAcrossTheSeam) {
  const test::TempFolder folder;
  RasterSpec spec = around_the_globe(64, 32, 4);
  spec.alpha = true;
  write_raster(folder / "input.tif", spec, [](std::int64_t x, std::int64_t, int band) {
    if (band == 3) return x == 63 || x == 20 ? 255.0 : 0.0;
    return x == 63 && band == 0 ? 200.0 : 0.0;
  });
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  request.options = {{"alpha", "associated"}};  // so that the finest level is not passed on byte for byte
  build(folder / "a.vts", request);
  const auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LayerInfo& layer = *reader->find_layer("color");
  const LevelValues values(*reader, layer, layer.finest);
  EXPECT_EQ(values.at(0, 5, 0), values.at(62, 5, 0));
  EXPECT_EQ(values.at(0, 5, 0), 200.0);
  EXPECT_EQ(values.at(0, 5, 3), 0.0);
  EXPECT_EQ(values.at(1, 5, 0), 0.0) << "out of reach";
}

TEST(ClosedLayer, MetadataAndSettingsSayIt) {
  const test::TempFolder folder;
  for (const bool closed : {true, false}) {
    RasterSpec spec = around_the_globe(128, 64, 1);
    if (!closed) spec.width = 127;
    write_raster(folder / "input.tif", spec, [](std::int64_t x, std::int64_t, int) { return static_cast<double>(x % 9); });
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kMaterial);
    request.options = {{"mixture", "2"}};
    std::filesystem::remove(folder / "a.vts");
    build(folder / "a.vts", request);
    const auto reader = store::StoreReader::open(folder / "a.vts");
    ASSERT_TRUE(reader.has_value());
    for (const LayerInfo& layer : reader->layers()) {
      if (layer.role != LayerRole::kTexture) continue;
      const auto metadata = nlohmann::json::parse(layer.metadata_json);
      EXPECT_EQ(metadata.value("periodic", ""), closed ? "x" : "") << layer.name;
    }
    const auto settings = nlohmann::json::parse(reader->find_layer("material")->metadata_json)["settings"];
    EXPECT_EQ(settings.contains("edges"), closed);
  }
}

// A change beside the seam reaches tiles at both ends, through the carry of all tiers.
TEST(ClosedLayer, AnUpdateLooksAcrossTheSeam) {
  for (const std::int64_t width : {std::int64_t{1024}, std::int64_t{1030}}) {
    const test::TempFolder folder;
    const RasterSpec spec = around_the_globe(width, 256);
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
    request.kernel = "kaiser5";
    write_raster(folder / "input.tif", spec, noisy_code);
    build(folder / "a.vts", request, {.threads = 2, .block_levels = 1});
    const Tiles before = tiles_of(folder / "a.vts", "color");
    write_raster(folder / "input.tif", spec, [](std::int64_t x, std::int64_t y, int band) {
      return x < 2 && y / 8 == 16 ? 255.0 - noisy_code(x, y, band) : noisy_code(x, y, band);
    });
    const BuildReport report = build(folder / "a.vts", request, {.threads = 2, .block_levels = 1, .update = true});
    EXPECT_GT(report.blocks_changed, 0);
    EXPECT_LT(report.blocks_changed, 20) << "of 68 blocks those at the seam";
    build(folder / "anew.vts", request, {.threads = 1, .block_levels = 1});
    for (const char* name : {"color", "color/carry", "color/sources"})
      EXPECT_TRUE(tiles_of(folder / "a.vts", name) == tiles_of(folder / "anew.vts", name)) << name << ", " << width << " columns";
    // The easternmost tile of the next level, whose own columns did not change.
    const auto after = tiles_of(folder / "a.vts", "color");
    const int level = after.rbegin()->first.level.value - 1;
    const auto east = std::ranges::find_if(after, [&](const auto& tile) {
      return tile.first.level.value == level && tile.first.x == static_cast<std::uint32_t>((width / 2 - 1) / 32) && tile.first.y == 2;
    });
    ASSERT_NE(east, after.end());
    EXPECT_NE(before.at(east->first), east->second);
  }
}

TEST(ClosedLayer, BlocksDependOnTheCarryAcrossTheSeam) {
  const test::TempFolder folder;
  for (const std::int64_t width : {std::int64_t{1024}, std::int64_t{1030}, std::int64_t{777}}) {
    write_raster(folder / "a.tif", around_the_globe(width, 200), noisy_code);
    const auto plan = plan_layer(request_for({folder / "a.tif"}, ChannelType::kColor), std::nullopt, 1 << 20);
    ASSERT_TRUE(plan.has_value());
    const WorkMap work(*plan, 1);
    for (std::size_t tier = 0; tier + 1 < work.tiers().size(); ++tier)
      for (std::int64_t j = 0; j < work.tiers()[tier + 1].blocks(); ++j) {
        const pyramid::BlockLevel base = work.plan_block(tier + 1, j).front();
        for (const std::int64_t column : pyramid::carry_columns(base, plan->info.tile_exponent))
          for (std::int64_t row = base.active.y >> 5; row <= (base.active.bottom() - 1) >> 5; ++row) {
            const std::int64_t i =
                work.tiers()[tier].block_of_carry({{}, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)});
            const std::vector<std::int64_t> dependents = work.dependents(tier, i);
            EXPECT_TRUE(std::ranges::find(dependents, j) != dependents.end())
                << width << " columns, tier " << tier << ": " << i << " to " << j;
            EXPECT_TRUE(std::ranges::is_sorted(dependents));
          }
      }
  }
}

// Sources on one side of the seam reach blocks on the other.
TEST(ClosedLayer, BlocksAcrossTheSeamOfASourceAreTouched) {
  const test::TempFolder folder;
  RasterSpec spec = around_the_globe(1030, 200);
  spec.width = 40;
  spec.alpha = true;
  spec.bands = 4;
  write_raster(folder / "a.tif", spec, noisy_code);
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kColor);
  request.area = Area{.west = -180.0, .south = 0.0, .east = 180.0, .north = 55.0};
  for (const int block_levels : {1, 2}) {
    const auto plan = plan_layer(request, std::nullopt, 1 << 20);
    ASSERT_TRUE(plan.has_value() && plan->is_closed);
    const WorkMap work(*plan, block_levels);
    for (std::size_t tier = 0; tier < work.tiers().size(); ++tier) {
      std::vector<std::int64_t> wanted;
      for (std::int64_t i = 0; i < work.tiers()[tier].blocks(); ++i)
        if (work.is_touched(tier, i)) wanted.push_back(i);
      EXPECT_EQ(work.touched(tier), wanted) << tier;
      EXPECT_TRUE(work.is_touched(tier, work.tiers()[tier].columns - 1)) << "the east end";
    }
    build(folder / ("blocks-" + std::to_string(block_levels) + ".vts"), request, {.threads = 2, .block_levels = block_levels});
  }
  build(folder / "whole.vts", request, {.threads = 1, .block_levels = 7});
  for (const char* name : {"blocks-1.vts", "blocks-2.vts"})
    EXPECT_TRUE(tiles_of(folder / name, "color") == tiles_of(folder / "whole.vts", "color")) << name;
}

// Tiles that were made by other rules for the edges do not mix with new ones.
TEST(EdgeRules, LayersOfOtherRulesAreNotGoneOnWith) {
  const test::TempFolder folder;
  struct Kind {
    std::string name;
    RasterSpec spec;
    ChannelType channel;
    bool has_rules;
  };
  for (const Kind& kind : {Kind{"wide kernel", {.width = 128, .height = 64}, ChannelType::kColor, true},
                           Kind{"cut heights", {.width = 129, .height = 64, .bands = 1}, ChannelType::kElevation, true},
                           Kind{"whole heights", {.width = 128, .height = 64, .bands = 1}, ChannelType::kElevation, false},
                           Kind{"cut masks", {.width = 129, .height = 64, .bands = 1}, ChannelType::kMask, false},
                           Kind{"one level", {.width = 31, .height = 32}, ChannelType::kColor, false},
                           Kind{"globe", around_the_globe(128, 64, 1), ChannelType::kMask, true}}) {
    std::filesystem::remove(folder / "a.vts");
    write_raster(folder / "input.tif", kind.spec, noisy_code);
    const LayerRequest request = request_for({folder / "input.tif"}, kind.channel);
    build(folder / "a.vts", request);
    const auto plan = plan_layer(request, *existing_frame(folder / "a.vts"), std::size_t{1} << 20);
    ASSERT_TRUE(plan.has_value());
    auto writer = open_or_create(folder / "a.vts", plan->crs, plan->extent());
    ASSERT_TRUE(writer.has_value());
    // As a builder without these rules would have left it.
    const LayerInfo layer = *writer->find_layer(request.name);
    auto metadata = nlohmann::ordered_json::parse(layer.metadata_json);
    EXPECT_EQ(metadata["settings"].erase("edges") > 0, kind.has_rules) << kind.name;
    ASSERT_TRUE(writer->set_metadata(layer.id, metadata.dump()).has_value());
    for (const bool update : {false, true}) {
      const auto gone_on = build_layer(*writer, *plan, {.update = update});
      EXPECT_EQ(gone_on.has_value(), !kind.has_rules) << kind.name;
      if (!gone_on) {
        EXPECT_EQ(gone_on.error().code, ErrorCode::kExists) << kind.name;
      }
    }
  }
}

}  // namespace
}  // namespace vt::pipeline
