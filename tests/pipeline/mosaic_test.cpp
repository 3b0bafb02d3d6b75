// Several sources, other grids, other projections.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "builder/pipeline/request/input_list.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

double any_code(std::int64_t x, std::int64_t y, int band) { return (x + y) % 100 + hash_noise(x, y, band) % 100 + 20; }

TEST(Mosaic, PiecesOnOneGridEqualTheWhole) {
  const test::TempFolder folder;
  const RasterSpec whole{.width = 180, .height = 140};
  write_raster(folder / "whole.tif", whole, any_code);
  std::vector<std::filesystem::path> pieces;
  // Four pieces with an overlap; the first is not the north-western one.
  for (const TexelRect& part : {TexelRect{90, 60, 90, 80}, TexelRect{0, 0, 95, 70}, TexelRect{80, 0, 100, 70}, TexelRect{0, 60, 100, 80}}) {
    RasterSpec spec = whole;
    spec.width = part.width;
    spec.height = part.height;
    spec.transform.x0 += static_cast<double>(part.x) * spec.transform.x_column;
    spec.transform.y0 += static_cast<double>(part.y) * spec.transform.y_row;
    pieces.push_back(folder / ("piece" + std::to_string(pieces.size()) + ".tif"));
    write_raster(pieces.back(), spec, [&](std::int64_t x, std::int64_t y, int band) { return any_code(x + part.x, y + part.y, band); });
  }
  build(folder / "whole.vts", request_for({folder / "whole.tif"}, ChannelType::kColor));
  for (const int block_levels : {1, 3}) {
    const auto path = folder / ("pieces" + std::to_string(block_levels) + ".vts");
    build(path, request_for(pieces, ChannelType::kColor), {.block_levels = block_levels});
    EXPECT_EQ(tiles_of(path, "color"), tiles_of(folder / "whole.vts", "color"));
  }
}

// Chunks full of opaque samples copy them, others go through filter space: a mosaic with gaps changes from
// one to the other many times, at places that depend on the blocks.
TEST(Mosaic, GapsAndOverlapsBuildTheSameAtAnyBlockSize) {
  const test::TempFolder folder;
  std::vector<std::filesystem::path> pieces;
  const RasterSpec whole{.width = 300, .height = 260};
  for (std::int64_t i = 0; i < 20; ++i) {
    if (i == 6 || i == 13) continue;  // holes inside the mosaic
    RasterSpec spec = whole;
    const TexelRect part{i % 5 * 60, i / 5 * 65, 60, 65 + (i % 3 == 0 ? 5 : 0)};
    spec.width = part.width;
    spec.height = std::min(part.height, whole.height - part.y);
    if (i == 8) spec.nodata = 50.0;
    spec.transform.x0 += static_cast<double>(part.x) * spec.transform.x_column;
    spec.transform.y0 += static_cast<double>(part.y) * spec.transform.y_row;
    pieces.push_back(folder / ("piece" + std::to_string(i) + ".tif"));
    write_raster(pieces.back(), spec, [&](std::int64_t x, std::int64_t y, int band) { return any_code(x + part.x, y + part.y, band); });
  }
  LayerRequest request = request_for(pieces, ChannelType::kColor);
  request.format = TexelFormat::kRgb8;
  std::optional<Tiles> first;
  for (const int block_levels : {1, 2, 4}) {
    const auto path = folder / ("blocks" + std::to_string(block_levels) + ".vts");
    build(path, request, {.block_levels = block_levels});
    Tiles tiles = tiles_of(path, "color");
    if (!first)
      first = std::move(tiles);
    else
      EXPECT_EQ(tiles, *first) << block_levels;
  }
  for (std::int64_t y = 0; y < whole.height; ++y)
    for (std::int64_t x = 0; x < whole.width; ++x) {
      const std::int64_t i = y / 65 * 5 + x / 60;
      if (i == 6 || i == 8 || i == 13 || y % 65 < 5) continue;
      const auto texel = texel_at<std::uint8_t, 3>(*first, 5, Level{4}, x, y);
      for (int band = 0; band < 3; ++band) ASSERT_EQ(texel[static_cast<std::size_t>(band)], any_code(x, y, band)) << x << "," << y;
    }
}

nlohmann::json quality_of(const std::filesystem::path& store_path) {
  const auto reader = store::StoreReader::open(store_path);
  EXPECT_TRUE(reader.has_value()) << reader.error().message;
  return nlohmann::json::parse(reader->find_layer("color")->metadata_json).at("quality");
}

// Rows that are copied are measured like those that are encoded: what is reported does not tell how the
// sources were cut.
TEST(Mosaic, TheQualityOfPiecesIsThatOfTheWhole) {
  const test::TempFolder folder;
  const RasterSpec whole{.width = 180, .height = 140, .nodata = 0.0};
  // Whole blocks: what stands in texels without data is not the same, and would show in those beside them.
  const auto is_hole = [](std::int64_t x, std::int64_t y) { return x >= 120 && y >= 72; };
  write_raster(folder / "whole.tif", whole,
               [&](std::int64_t x, std::int64_t y, int band) { return is_hole(x, y) ? 0.0 : any_code(x, y, band); });
  std::vector<std::filesystem::path> pieces;
  // The upper two fill whole chunks together; beside the lower one there is nothing.
  for (const TexelRect& part : {TexelRect{0, 0, 90, 72}, TexelRect{90, 0, 90, 72}, TexelRect{0, 72, 120, 68}}) {
    RasterSpec spec = whole;
    spec.width = part.width;
    spec.height = part.height;
    spec.transform.x0 += static_cast<double>(part.x) * spec.transform.x_column;
    spec.transform.y0 += static_cast<double>(part.y) * spec.transform.y_row;
    pieces.push_back(folder / ("piece" + std::to_string(pieces.size()) + ".tif"));
    write_raster(pieces.back(), spec, [&](std::int64_t x, std::int64_t y, int band) { return any_code(x + part.x, y + part.y, band); });
  }
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kBc1}) {
    const std::string name(format_info(format).name);
    LayerRequest request = request_for({folder / "whole.tif"}, ChannelType::kColor);
    request.format = format;
    build(folder / (name + "-whole.vts"), request, {.block_levels = 2});
    request = request_for(pieces, ChannelType::kColor);
    request.format = format;
    build(folder / (name + "-pieces.vts"), request, {.block_levels = 2});
    const nlohmann::json quality = quality_of(folder / (name + "-pieces.vts"));
    EXPECT_EQ(quality, quality_of(folder / (name + "-whole.vts"))) << name;
    EXPECT_EQ(quality[0]["levels"][0]["measured"], 3 * (180 * 140 - 60 * 68)) << name << ": three numbers of every texel with data";
  }
}

// More files than a list in the settings holds, named by their folder.
TEST(Mosaic, AFolderOfManyFilesEqualsTheWhole) {
  const test::TempFolder folder;
  const RasterSpec whole{.width = 320, .height = 320, .bands = 1, .type = SampleType::kInt16, .nodata = -5.0};
  const auto height = [](std::int64_t x, std::int64_t y, int) { return (x * 3 + y) % 37 == 0 ? -5.0 : static_cast<double>(x * 7 - y * 5); };
  write_raster(folder / "whole.tif", whole, height);
  std::filesystem::create_directory(folder / "tiles");
  for (std::int64_t y = 0; y < 10; ++y)
    for (std::int64_t x = 0; x < 10; ++x) {
      RasterSpec spec = whole;
      spec.width = spec.height = 32;
      spec.transform.x0 += static_cast<double>(x * 32) * spec.transform.x_column;
      spec.transform.y0 += static_cast<double>(y * 32) * spec.transform.y_row;
      const std::string name = "tiles/" + std::to_string(y) + "_" + std::to_string(x) + ".tif";
      write_raster(folder / name, spec, [&](std::int64_t i, std::int64_t j, int band) { return height(i + x * 32, j + y * 32, band); });
    }
  const BuildReport wanted = build(folder / "whole.vts", request_for({folder / "whole.tif"}, ChannelType::kElevation));
  const LayerRequest request = request_for(expand_input(folder / "tiles").value(), ChannelType::kElevation);
  EXPECT_EQ(build(folder / "tiles.vts", request).tiles, wanted.tiles);
  EXPECT_EQ(tiles_of(folder / "tiles.vts", "elevation"), tiles_of(folder / "whole.vts", "elevation"));
  EXPECT_TRUE(build(folder / "tiles.vts", request).was_complete) << "the same files again are the same settings";

  // One sample of one of them: the store knows that it was built from others.
  RasterSpec changed = whole;
  changed.width = changed.height = 32;
  changed.transform.x0 += 9 * 32 * changed.transform.x_column;
  changed.transform.y0 += 9 * 32 * changed.transform.y_row;
  write_raster(folder / "tiles/9_9.tif", changed, [&](auto, auto, int) { return 1.0; });
  const auto after = plan_layer(request, std::nullopt, 1 << 20);
  ASSERT_TRUE(after.has_value());
  EXPECT_EQ(after->settings["sources"]["count"], 100);
  auto reader = store::StoreReader::open(folder / "tiles.vts");
  const auto stored = nlohmann::json::parse(reader->find_layer("elevation")->metadata_json);
  EXPECT_NE(stored["settings"]["sources"]["content"], after->settings["sources"]["content"]);
}

TEST(Mosaic, OfSeveralBadFilesTheFirstIsNamed) {
  const test::TempFolder folder;
  std::vector<std::filesystem::path> pieces;
  for (int i = 0; i < 30; ++i) {
    pieces.push_back(folder / ("p" + std::to_string(i) + ".tif"));
    if (i < 11) write_raster(pieces.back(), {.width = 8, .height = 8}, any_code);
  }
  for (int round = 0; round < 5; ++round) {
    const auto plan = plan_layer(request_for(pieces, ChannelType::kColor), std::nullopt, {.threads = 4});
    ASSERT_FALSE(plan.has_value());
    EXPECT_NE(plan.error().message.find("p11.tif"), std::string::npos) << plan.error().message;
  }
}

TEST(Mosaic, LaterSourcesLieOverEarlierOnes) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 40, .height = 40};
  write_raster(folder / "below.tif", spec, [](auto, auto, int) { return 10.0; });
  RasterSpec above = spec;
  above.nodata = 0.0;
  write_raster(folder / "above.tif", above, [](std::int64_t x, auto, int) { return x < 20 ? 0.0 : 200.0; });
  LayerRequest request = request_for({folder / "below.tif", folder / "above.tif"}, ChannelType::kColor);
  request.format = TexelFormat::kRgb8;
  build(folder / "a.vts", request);
  const Tiles tiles = tiles_of(folder / "a.vts", "color");
  EXPECT_EQ((texel_at<std::uint8_t, 3>(tiles, 5, Level{1}, 19, 5))[0], 10) << "no data above lets the layer below through";
  EXPECT_EQ((texel_at<std::uint8_t, 3>(tiles, 5, Level{1}, 20, 5))[0], 200);
}

// A raster whose values are its own eastings (or northings): whatever is resampled from it says where it was
// taken from.
TEST(Resampling, PutsEveryTexelWithinAHundredthOfItsPlace) {
  const test::TempFolder folder;
  const geo::Crs utm = utm33();
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  for (const bool eastings : {true, false}) {
    RasterSpec spec{.width = 400, .height = 300, .bands = 1, .type = SampleType::kFloat32};
    spec.transform = {600000.0, 10.0, 0.0, 7000000.0, 0.0, -10.0};
    // Offsets keep the numbers small, so that floats hold them to 2e-4 m.
    write_raster(folder / "place.tif", spec, [&](std::int64_t x, std::int64_t y, int) {
      return eastings ? (static_cast<double>(x) + 0.5) * 10.0 : -(static_cast<double>(y) + 0.5) * 10.0;
    });
    LayerRequest request = request_for({folder / "place.tif"}, ChannelType::kElevation);
    request.crs = geographic;
    const auto path = folder / (eastings ? "e.vts" : "n.vts");
    build(path, request, {.block_levels = 2});
    auto reader = store::StoreReader::open(path);
    const LayerInfo& layer = *reader->find_layer("elevation");
    const VtMapping mapping(reader->description().area, layer);
    const Tiles tiles = tiles_of(path, "elevation");
    int checked = 0;
    for (std::int64_t y = 0; y < layer.data.height; y += 3)
      for (std::int64_t x = 0; x < layer.data.width; x += 3) {
        const Point2 lonlat = mapping.crs_from_texel(layer.finest, {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
        const Point2 place = utm.crs_from_lonlat(lonlat).value();
        const double wanted = eastings ? place.x - 600000.0 : place.y - 7000000.0;
        // Half a sample from the edge the outermost sample is repeated.
        const double margin = 6.0;
        const bool inside =
            place.x > 600000 + margin && place.x < 604000 - margin && place.y < 7000000 - margin && place.y > 6997000 + margin;
        if (!inside) continue;
        const float found = texel_at<float, 1>(tiles, 5, layer.finest, x, y)[0];
        ASSERT_NEAR(found, wanted, 0.01 * 10.0) << "texel " << x << "," << y;
        ++checked;
      }
    EXPECT_GT(checked, 5000);
  }
}

// A second source that misses the layer's grid by part of a texel.
TEST(Resampling, NearestMovesAGridThatIsOffByPartOfATexel) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 60, .height = 50, .bands = 1, .type = SampleType::kInt16};
  write_raster(folder / "base.tif", spec, [](auto, auto, int) { return 1.0; });
  const auto height = [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(100 + x * 30 + y); };
  for (const auto& [fx, fy] : std::vector<std::pair<double, double>>{{0.3, 0.0}, {0.5, 0.5}, {0.7, 0.2}, {-0.4, 0.9}}) {
    RasterSpec off = spec;
    off.width = 20;
    off.height = 20;
    off.transform.x0 += (10 + fx) * 2.0;
    off.transform.y0 -= (15 + fy) * 2.0;
    write_raster(folder / "off.tif", off, height);
    LayerRequest request = request_for({folder / "base.tif", folder / "off.tif"}, ChannelType::kElevation);
    request.resample = resample::Method::kNearest;
    const auto plan = plan_layer(request, std::nullopt, 1 << 20);
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    ASSERT_EQ(plan->warnings.size(), 1U);
    EXPECT_NE(plan->warnings[0].find("off.tif: moved by"), std::string::npos) << plan->warnings[0];
    const auto path = folder / ("off" + std::to_string(fx) + ".vts");
    build(path, request);
    const Tiles tiles = tiles_of(path, "elevation");
    for (std::int64_t y = 0; y < 50; ++y)
      for (std::int64_t x = 0; x < 60; ++x) {
        // Definition: the sample that the texel's centre lies in.
        const auto column = static_cast<std::int64_t>(std::floor(static_cast<double>(x) + 0.5 - 10 - fx + 1e-9));
        const auto row = static_cast<std::int64_t>(std::floor(static_cast<double>(y) + 0.5 - 15 - fy + 1e-9));
        const bool covered = column >= 0 && row >= 0 && column < 20 && row < 20;
        ASSERT_EQ((texel_at<float, 1>(tiles, 5, Level{1}, x, y)[0]), covered ? static_cast<float>(height(column, row, 0)) : 1.0F)
            << x << "," << y << " off by " << fx;
      }
    request.resample = resample::Method::kBilinear;
    EXPECT_NE(plan_layer(request, std::nullopt, 1 << 20)->warnings.at(0).find("resampled (bilinear)"), std::string::npos);
  }
}

TEST(Resampling, ARotatedRasterComesOutUpright) {
  const test::TempFolder folder;
  RasterSpec spec{.width = 200, .height = 200, .bands = 1, .type = SampleType::kFloat32};
  const double c = std::cos(0.5) * 2.0;
  const double s = std::sin(0.5) * 2.0;
  spec.transform = {500000.0, c, s, 5400000.0, s, -c};
  write_raster(folder / "turned.tif", spec, [&](std::int64_t x, std::int64_t y, int) {
    return spec.transform.crs_from_raster({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5}).x - 500000.0;
  });
  build(folder / "a.vts", request_for({folder / "turned.tif"}, ChannelType::kElevation));
  auto reader = store::StoreReader::open(folder / "a.vts");
  const LayerInfo& layer = *reader->find_layer("elevation");
  const VtMapping mapping(reader->description().area, layer);
  const Tiles tiles = tiles_of(folder / "a.vts", "elevation");
  // The middle of the square, well inside.
  for (std::int64_t y = layer.data.height / 2 - 40; y < layer.data.height / 2 + 40; y += 7)
    for (std::int64_t x = layer.data.width / 2 - 40; x < layer.data.width / 2 + 40; x += 7) {
      const Point2 place = mapping.crs_from_texel(layer.finest, {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
      EXPECT_NEAR((texel_at<float, 1>(tiles, 5, layer.finest, x, y))[0], place.x - 500000.0, 0.01 * 2.0);
    }
}

}  // namespace
}  // namespace vt::pipeline
