// Whole layers of heights: bounds that bound, vertices that neighbours share, codes that both sides of an edge decode alike, voids that
// stay.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/pipeline/level_values.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// Ridges over a few scales, with voids in places: like terrain, and reproducible.
double terrain(std::int64_t x, std::int64_t y) {
  double height = 400.0;
  double amplitude = 150.0;
  for (int octave = 0; octave < 6; ++octave, amplitude *= 0.55) {
    const double scale = static_cast<double>(1 << octave) / 90.0;
    height += amplitude * std::sin(static_cast<double>(x) * scale + 1.3 * octave) * std::cos(static_cast<double>(y) * scale * 0.8 + octave);
  }
  return height + static_cast<double>(hash_noise(x, y, 0) % 1000) / 250.0;
}

bool is_hole(std::int64_t x, std::int64_t y) { return (x / 19) % 5 == 2 && (y / 13) % 4 == 1; }

constexpr double kVoid = -9999.0;

double holed_terrain(std::int64_t x, std::int64_t y, int) { return is_hole(x, y) ? kVoid : terrain(x, y); }

RasterSpec spec_of(std::int64_t width, std::int64_t height) {
  return {.width = width, .height = height, .bands = 1, .type = SampleType::kFloat32, .nodata = kVoid};
}

// The reader keeps its map when the folder goes.
struct Built {
  Result<store::StoreReader> reader;
};

Built built(const RasterSpec& spec, const std::function<double(std::int64_t, std::int64_t, int)>& value, TexelFormat format,
            const channels::Options& options, const std::string& kernel = "box", int block_levels = 0) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", spec, value);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kElevation);
  request.format = format;
  request.kernel = kernel;
  request.options = options;
  if (format == TexelFormat::kR16) request.range = std::array<double, 2>{-500.0, 1500.0};
  build(folder / "a.vts", request, {.block_levels = block_levels});
  return {store::StoreReader::open(folder / "a.vts")};
}

TEST(ElevationLayer, BoundsHoldEveryHeightUnderThemInEveryFormatKernelSizeAndBlocking) {
  struct Size {
    std::int64_t width;
    std::int64_t height;
  };
  for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16})
    for (const char* kernel : {"box", "point"})
      for (const Size size : {Size{301, 203}, Size{257, 1}, Size{1, 129}})
        for (const int block_levels : {1, 3}) {
          const Built b = built(spec_of(size.width, size.height), holed_terrain, format, {{"bounds", "yes"}}, kernel, block_levels);
          ASSERT_TRUE(b.reader.has_value());
          const LayerInfo& layer = *b.reader->find_layer("elevation");
          const LayerInfo& bounds = *b.reader->find_layer("elevation/bounds");
          EXPECT_EQ(b.reader->lookup(bounds.id, {bounds.finest, 0, 0})->kind, store::TileKind::kAbsent) << "the base is its own bounds";
          const LevelValues stored_base(*b.reader, layer, layer.finest);
          for (int steps = 1; steps <= layer.finest.value; ++steps) {
            const LevelValues values(*b.reader, bounds, Level{static_cast<std::uint8_t>(layer.finest.value - steps)});
            double slack = 0.0;  // how far they may lie outside: what rounding adds
            for (std::int64_t y = 0; y < values.height(); ++y)
              for (std::int64_t x = 0; x < values.width(); ++x) {
                double least = 1e9;
                double greatest = -1e9;
                for (std::int64_t v = y << steps; v < std::min((y + 1) << steps, size.height); ++v)
                  for (std::int64_t u = x << steps; u < std::min((x + 1) << steps, size.width); ++u) {
                    if (is_hole(u, v)) continue;
                    const auto source = static_cast<double>(static_cast<float>(terrain(u, v)));
                    least = std::min({least, source, stored_base.at(u, v)});
                    greatest = std::max({greatest, source, stored_base.at(u, v)});
                  }
                if (least > greatest) {
                  ASSERT_TRUE(values.is_void(x, y)) << format_info(format).name << " " << kernel << " " << x << "," << y;
                  continue;
                }
                ASSERT_LE(values.at(x, y, 0), least) << format_info(format).name << " " << kernel << " " << steps << ": " << x << "," << y;
                ASSERT_GE(values.at(x, y, 1), greatest)
                    << format_info(format).name << " " << kernel << " " << steps << ": " << x << "," << y;
                slack = std::max({slack, least - values.at(x, y, 0), values.at(x, y, 1) - greatest});
              }
            // One step of the format at most: of floats none, of halves up to 1024 m half a metre, of codes over 2000 m 1/32 m.
            EXPECT_LE(slack, format == TexelFormat::kR32Float   ? 0.0
                             : format == TexelFormat::kR16Float ? 0.5
                                                                : 1.0 / 32)
                << format_info(format).name;
          }
        }
}

TEST(ElevationLayer, CodesLieOnOneQuantumAndWithinHalfOfItOfEveryHeight) {
  const Built b = built(spec_of(301, 203), holed_terrain, TexelFormat::kR16, {});
  const Built floats = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {});
  ASSERT_TRUE(b.reader.has_value() && floats.reader.has_value());
  const LayerInfo& layer = *b.reader->find_layer("elevation");
  EXPECT_EQ(layer.components[0].scale, 1.0 / 32) << "2000 m in 65534 steps";
  EXPECT_TRUE(layer.zero_is_nodata);
  for (int level = 0; level <= layer.finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const LevelValues coded(*b.reader, layer, l);
    const LevelValues exact(*floats.reader, *floats.reader->find_layer("elevation"), l);
    for (std::int64_t y = 0; y < coded.height(); ++y)
      for (std::int64_t x = 0; x < coded.width(); ++x) {
        ASSERT_EQ(coded.is_void(x, y), exact.is_void(x, y)) << "level " << level << ": " << x << "," << y;
        if (coded.is_void(x, y)) continue;
        ASSERT_LE(std::abs(coded.at(x, y) - exact.at(x, y)), 1.0 / 64);
        ASSERT_EQ(coded.at(x, y) * 32, std::floor(coded.at(x, y) * 32)) << "every tile rounds to the same heights";
      }
  }
}

TEST(ElevationLayer, TheErrorInTheMetadataIsWhatTheFormatLoses) {
  const Built b = built(spec_of(301, 203), holed_terrain, TexelFormat::kR16, {{"quantum", "0.5"}});
  ASSERT_TRUE(b.reader.has_value());
  const auto metadata = nlohmann::json::parse(b.reader->find_layer("elevation")->metadata_json);
  for (const auto& measure : metadata["quality"]) {
    if (measure["name"] != "height") continue;
    for (const auto& level : measure["levels"]) {
      EXPECT_LE(level["max"].get<double>(), 0.25) << "half a quantum";
      EXPECT_NEAR(level["rms"].get<double>(), 0.5 / std::sqrt(12.0), 0.05) << "uniform rounding, of few texels in the coarsest level";
    }
  }
}

TEST(ElevationLayer, PointLevelsShareTheirVertices) {
  const Built b = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {}, "point", 1);
  ASSERT_TRUE(b.reader.has_value());
  const LayerInfo& layer = *b.reader->find_layer("elevation");
  for (int steps = 0; steps <= layer.finest.value; ++steps) {
    const LevelValues values(*b.reader, layer, Level{static_cast<std::uint8_t>(layer.finest.value - steps)});
    for (std::int64_t y = 0; y < values.height(); ++y)
      for (std::int64_t x = 0; x < values.width(); ++x) {
        const std::int64_t u = x << steps;
        const std::int64_t v = y << steps;
        ASSERT_EQ(values.is_void(x, y), is_hole(u, v)) << "level " << steps << ": " << x << "," << y;
        if (is_hole(u, v)) continue;
        ASSERT_EQ(values.at(x, y), static_cast<double>(static_cast<float>(terrain(u, v))));
      }
  }
}

// No data anywhere that the coarse vertices see, yet bounds have to know of the rest.
TEST(ElevationLayer, BoundsAreThereWherePointsAreAllVoid) {
  const Built b = built(
      spec_of(256, 256), [](std::int64_t x, std::int64_t y, int) { return x % 2 == 1 && y % 2 == 1 ? 7.0 : kVoid; }, TexelFormat::kR32Float,
      {{"bounds", "yes"}}, "point");
  ASSERT_TRUE(b.reader.has_value());
  const LevelValues bounds(*b.reader, *b.reader->find_layer("elevation/bounds"), Level{0});
  for (std::int64_t i = 0; i < bounds.width(); ++i) {
    EXPECT_EQ(bounds.at(i, i, 0), 7.0);
    EXPECT_EQ(bounds.at(i, i, 1), 7.0);
  }
}

TEST(ElevationLayer, HeightsThatDoNotFitStopTheBuildAndAreNamed) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32},
               [](std::int64_t x, std::int64_t y, int) { return x == 40 && y == 20 ? 1234.5 : 100.0; });
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kElevation);
  request.format = TexelFormat::kR16;
  request.range = std::array<double, 2>{0.0, 1000.0};
  const auto plan = plan_layer(request, std::nullopt, std::size_t{1} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  auto writer = open_or_create(folder / "a.vts", plan->crs, plan->extent());
  ASSERT_TRUE(writer.has_value());
  const auto report = build_layer(*writer, *plan, {});
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(report.error().message.find("1234.5"), std::string::npos) << report.error().message;
  EXPECT_NE(report.error().message.find("--range"), std::string::npos) << report.error().message;
  EXPECT_NE(report.error().message.find("row 20"), std::string::npos) << report.error().message;
}

TEST(ElevationLayer, FillIsStoredButPullsNoMeanDown) {
  const Built plain = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {});
  const Built filled = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {{"fill", "-3"}, {"bounds", "yes"}});
  ASSERT_TRUE(plain.reader.has_value() && filled.reader.has_value());
  const LayerInfo& layer = *filled.reader->find_layer("elevation");
  EXPECT_EQ(nlohmann::json::parse(layer.metadata_json)["settings"]["options"]["fill"], "-3");
  for (int level = 0; level <= layer.finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const LevelValues without(*plain.reader, *plain.reader->find_layer("elevation"), l);
    const LevelValues with(*filled.reader, layer, l);
    for (std::int64_t y = 0; y < with.height(); ++y)
      for (std::int64_t x = 0; x < with.width(); ++x)
        ASSERT_EQ(with.at(x, y), without.is_void(x, y) ? -3.0 : without.at(x, y)) << "level " << level << ": " << x << "," << y;
  }
  // The base is filled, so its bounds are too.
  const LevelValues bounds(*filled.reader, *filled.reader->find_layer("elevation/bounds"), Level{0});
  EXPECT_EQ(bounds.at(0, 0, 0), -3.0);
}

}  // namespace
}  // namespace vt::pipeline
