// Whole layers of heights: bounds that bound, vertices that neighbours share, codes that both sides of an
// edge decode alike, voids that stay.
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
            const LevelValues heights(*b.reader, layer, Level{static_cast<std::uint8_t>(layer.finest.value - steps)});
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
                const double stored = heights.is_void(x, y) ? least : heights.at(x, y);
                ASSERT_TRUE(values.at(x, y, 0) <= stored && values.at(x, y, 1) >= stored) << "the level's own height";
                // At a cut edge the level's own height is continued past those under the texel.
                const bool is_cut = kernel == std::string("box") && ((x + 1) << steps > size.width || (y + 1) << steps > size.height);
                if (!is_cut) slack = std::max({slack, least - values.at(x, y, 0), values.at(x, y, 1) - greatest});
              }
            // One step of the format at most: of floats none, of halves up to 1024 m half a metre, of codes
            // over 2000 m 1/32 m.
            EXPECT_LE(slack, format == TexelFormat::kR32Float   ? 0.0
                             : format == TexelFormat::kR16Float ? 0.5
                                                                : 1.0 / 32)
                << format_info(format).name;
          }
        }
}

// Heights that no float can hold. Bounds are compared with the samples themselves; means and reported errors with
// sums in long double.
TEST(ElevationLayer, WideHeightsAreBoundedOutwardAndReportedTruly) {
  using Height = std::function<double(std::int64_t, std::int64_t, int)>;
  struct Kind {
    SampleType type;
    TexelFormat format;
    std::optional<std::array<double, 2>> range;
    Height height;
  };
  const auto relief = [](double base, double height) -> Height {
    return [=](std::int64_t x, std::int64_t y, int) { return base + height * (hash_noise(x, y, 3) % 1000003) / 1000003.0; };
  };
  const Height near_2_31 = [](std::int64_t x, std::int64_t y, int) { return 2147483647.0 - hash_noise(x, y, 0) % 1000; };
  const std::vector<Kind> kinds{
      {SampleType::kFloat64, TexelFormat::kR32Float, {}, relief(8000.0, 50.0)},
      {SampleType::kFloat64, TexelFormat::kR16, {{7900.0, 8100.0}}, relief(8000.0, 50.0)},
      {SampleType::kFloat64, TexelFormat::kR16, {{6370000.0, 6380000.0}}, relief(6378000.0, 50.0)},
      {SampleType::kFloat64, TexelFormat::kR16, {{999999.99, 1000000.01}}, relief(1e6, 0.002)},
      {SampleType::kInt32, TexelFormat::kR32Float, {}, relief(1e8, 1e6)},
      {SampleType::kInt32, TexelFormat::kR32Float, {}, near_2_31},
      {SampleType::kUint32, TexelFormat::kR32Float, {}, [&](std::int64_t x, std::int64_t y, int b) { return near_2_31(x, y, b) + 2e9; }},
  };
  // No texel of any level is cut by an edge, where heights belong to the texel's centre.
  constexpr std::int64_t kWidth = 96;
  constexpr std::int64_t kHeight = 64;
  for (const Kind& kind : kinds) {
    const test::TempFolder folder;
    write_raster(folder / "input.tif", {.width = kWidth, .height = kHeight, .bands = 1, .type = kind.type}, kind.height);
    const auto sample = [&](std::int64_t x, std::int64_t y) {
      const double height = kind.height(x, y, 0);
      return kind.type == SampleType::kFloat64 ? height : std::trunc(height);
    };
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kElevation);
    request.format = kind.format;
    request.range = kind.range;
    request.options = {{"bounds", "yes"}};
    request.tile_texels = 16;
    build(folder / "a.vts", request, {.block_levels = 1});
    auto reader = store::StoreReader::open(folder / "a.vts");
    ASSERT_TRUE(reader.has_value());
    const LayerInfo& layer = *reader->find_layer("elevation");
    const auto rows = nlohmann::json::parse(layer.metadata_json).at("quality").at(0).at("levels");
    for (int steps = 0; steps <= layer.finest.value; ++steps) {
      const Level level{static_cast<std::uint8_t>(layer.finest.value - steps)};
      const LevelValues means(*reader, layer, level);
      const LevelValues bounds(*reader, *reader->find_layer("elevation/bounds"), level);
      const std::int64_t size = std::int64_t{1} << steps;
      double largest = 0.0;
      double squares = 0.0;
      for (std::int64_t y = 0; y < means.height(); ++y)
        for (std::int64_t x = 0; x < means.width(); ++x) {
          long double sum = 0.0L;
          std::int64_t count = 0;
          double least = std::numeric_limits<double>::infinity();
          double greatest = -least;
          for (std::int64_t fy = y * size; fy < std::min((y + 1) * size, kHeight); ++fy)
            for (std::int64_t fx = x * size; fx < std::min((x + 1) * size, kWidth); ++fx, ++count) {
              sum += static_cast<long double>(sample(fx, fy));
              least = std::min(least, sample(fx, fy));
              greatest = std::max(greatest, sample(fx, fy));
            }
          if (steps > 0) {
            ASSERT_LE(bounds.at(x, y, 0), least) << sample_name(kind.type) << " level " << steps;
            ASSERT_GE(bounds.at(x, y, 1), greatest) << sample_name(kind.type) << " level " << steps;
          }
          const double error = means.at(x, y) - static_cast<double>(sum / static_cast<long double>(count));
          largest = std::max(largest, std::abs(error));
          squares += error * error;
        }
      const auto& row = rows.at(static_cast<std::size_t>(steps));
      const double rms = std::sqrt(squares / static_cast<double>(means.width() * means.height()));
      // Planes hold 48 bits and lose one of them a level.
      const double slack = 8 * std::abs(sample(0, 0)) * 0x1p-48;
      EXPECT_NEAR(row.at("max").get<double>(), largest, slack) << sample_name(kind.type) << " level " << steps;
      EXPECT_NEAR(row.at("rms").get<double>(), rms, slack) << sample_name(kind.type) << " level " << steps;
      const double half_step =
          kind.format == TexelFormat::kR16 ? 0.5 * layer.components[0].scale : std::ldexp(1.0, std::ilogb(sample(0, 0)) - 24);
      EXPECT_LE(largest, half_step + slack) << "what the format itself loses, and no more";
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
  EXPECT_NE(report.error().message.find("`range`"), std::string::npos) << report.error().message;
  EXPECT_NE(report.error().message.find("row 20"), std::string::npos) << report.error().message;
}

// A slope that ends in a cut texel: the height at its centre would lie past the range, which was given for
// the heights that there are.
TEST(ElevationLayer, HeightsAtCutEdgesStayWithinTheRangeThatWasGiven) {
  const auto slope = [](std::int64_t x, std::int64_t, int) { return static_cast<double>(10 * x); };
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 65, .height = 40, .bands = 1, .type = SampleType::kInt16}, slope);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kElevation);
  request.format = TexelFormat::kR16;
  request.range = std::array<double, 2>{0.0, 640.0};
  build(folder / "a.vts", request);
  const auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LayerInfo& layer = *reader->find_layer("elevation");
  for (int steps = 0; steps <= layer.finest.value; ++steps) {
    const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(layer.finest.value - steps)});
    const double last = values.at(values.width() - 1, 0);
    EXPECT_GE(last, 640.0 - layer.components[0].scale);
    EXPECT_LE(last, layer.components[0].offset + layer.components[0].scale * 65535.0);
  }
}

TEST(ElevationLayer, FillIsStoredButPullsNoMeanDown) {
  const Built plain = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {});
  const Built filled = built(spec_of(301, 203), holed_terrain, TexelFormat::kR32Float, {{"fill", "-3"}, {"bounds", "yes"}});
  ASSERT_TRUE(plain.reader.has_value() && filled.reader.has_value());
  const LayerInfo& layer = *filled.reader->find_layer("elevation");
  EXPECT_EQ(nlohmann::json::parse(layer.metadata_json)["filled_m"], -3.0);
  for (int level = 0; level <= layer.finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const LevelValues without(*plain.reader, *plain.reader->find_layer("elevation"), l);
    const LevelValues with(*filled.reader, layer, l);
    for (std::int64_t y = 0; y < with.height(); ++y)
      for (std::int64_t x = 0; x < with.width(); ++x)
        ASSERT_EQ(with.at(x, y), without.is_void(x, y) ? -3.0 : without.at(x, y)) << "level " << level << ": " << x << "," << y;
  }
  // The base is filled, so its bounds are too: the void at columns 38 to 56 and rows 13 to 25 is partly under
  // texel 2, 0 of 16 x 16.
  const LevelValues bounds(*filled.reader, *filled.reader->find_layer("elevation/bounds"), Level{0});
  EXPECT_EQ(bounds.at(2, 0, 0), -3.0);
  EXPECT_GT(bounds.at(0, 0, 0), 0.0);
}

// max | z - bilinear(z_l) | over the finest texels, in the words of the definition.
double surface_error(const LevelValues& base, const LevelValues& level, int steps, bool is_point) {
  double worst = 0.0;
  const double scale = std::exp2(-steps);
  for (std::int64_t y = 0; y < base.height(); ++y)
    for (std::int64_t x = 0; x < base.width(); ++x) {
      const auto place = [&](std::int64_t texel, std::int64_t count) {
        const double at = is_point ? static_cast<double>(texel) * scale : (static_cast<double>(texel) + 0.5) * scale - 0.5;
        return std::clamp(at, 0.0, static_cast<double>(count - 1));
      };
      const double u = place(x, level.width());
      const double v = place(y, level.height());
      double surface = 0.0;
      for (std::int64_t j = 0; j < level.height(); ++j) {
        const double wy = 1.0 - std::abs(v - static_cast<double>(j));
        if (wy <= 0.0) continue;
        for (std::int64_t i = static_cast<std::int64_t>(u); i <= static_cast<std::int64_t>(u) + 1 && i < level.width(); ++i) {
          const double wx = 1.0 - std::abs(u - static_cast<double>(i));
          if (wx > 0.0) surface += wx * wy * level.at(i, j);
        }
      }
      const double difference = std::abs(base.at(x, y) - surface);
      if (!std::isnan(difference)) worst = std::max(worst, difference);
    }
  return worst;
}

TEST(ElevationLayer, TheSurfaceErrorOfEveryLevelIsTheLargestDifferenceFromTheFinest) {
  for (const char* kernel : {"box", "point"})
    for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16}) {
      const Built b = built(spec_of(150, 101), holed_terrain, format, {{"surface-error", "yes"}}, kernel, 1);
      ASSERT_TRUE(b.reader.has_value());
      const LayerInfo& layer = *b.reader->find_layer("elevation");
      const auto metadata = nlohmann::json::parse(layer.metadata_json);
      const LevelValues base(*b.reader, layer, layer.finest);
      int levels = 0;
      for (const auto& measure : metadata["quality"]) {
        if (measure["name"] != "surface") continue;
        for (const auto& row : measure["levels"]) {
          ++levels;
          const int level = row["level"];
          const LevelValues values(*b.reader, layer, Level{static_cast<std::uint8_t>(level)});
          const double wanted = surface_error(base, values, layer.finest.value - level, std::string(kernel) == "point");
          EXPECT_NEAR(row["max"].get<double>(), wanted, 1e-9)
              << kernel << " level " << level << ": sums in another order, heights below 2^11";
        }
      }
      EXPECT_EQ(levels, layer.finest.value) << "every level but the finest";
    }
}

TEST(ElevationLayer, APlaneHasNoSurfaceErrorAwayFromItsEdge) {
  // Bilinear surfaces through means of a plane are the plane; outside the outermost centres the surface goes
  // on level.
  const Built b = built(spec_of(128, 128),
                        [](std::int64_t x, std::int64_t y, int) { return 3.0 * static_cast<double>(x) + 0.5 * static_cast<double>(y); },
                        TexelFormat::kR32Float, {{"surface-error", "yes"}});
  ASSERT_TRUE(b.reader.has_value());
  const auto metadata = nlohmann::json::parse(b.reader->find_layer("elevation")->metadata_json);
  for (const auto& measure : metadata["quality"]) {
    if (measure["name"] != "surface") continue;
    for (const auto& row : measure["levels"]) {
      const double texel = std::exp2(2 - row["level"].get<int>());
      EXPECT_EQ(row["max"].get<double>(), 3.5 * 0.5 * (texel - 1.0)) << "half a texel less half a finest one, at the corner";
    }
  }
}

class RealTerrain : public ::testing::TestWithParam<const char*> {};

TEST_P(RealTerrain, KeepsItsMeanAndItsVoids) {
  const std::filesystem::path input = std::filesystem::path(VT_TEST_DATA) / "elevation" / GetParam();
  if (!std::filesystem::exists(input)) GTEST_SKIP() << input << " is not there";
  const test::TempFolder folder;
  LayerRequest request = request_for({input}, ChannelType::kElevation);
  request.options = {{"bounds", "yes"}, {"surface-error", "yes"}};
  build(folder / "a.vts", request);
  auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LayerInfo& layer = *reader->find_layer("elevation");
  const LevelValues base(*reader, layer, layer.finest);
  // For every level: its mean, weighed by how many finest texels with data each texel stands for, is the mean
  // of the finest. Where the edge cuts a texel, its height is not a mean but that of its centre.
  for (int steps = 1; steps <= layer.finest.value; ++steps) {
    const Level level{static_cast<std::uint8_t>(layer.finest.value - steps)};
    const LevelValues values(*reader, layer, level);
    const LevelValues bounds(*reader, *reader->find_layer("elevation/bounds"), level);
    double sum = 0.0;
    double finest_sum = 0.0;
    double finest_count = 0.0;
    for (std::int64_t y = 0; y < values.height(); ++y)
      for (std::int64_t x = 0; x < values.width(); ++x) {
        const bool is_cut = (x + 1) << steps > base.width() || (y + 1) << steps > base.height();
        double count = 0.0;
        double heights = 0.0;
        double least = 1e9;
        double greatest = -1e9;
        for (std::int64_t v = y << steps; v < std::min((y + 1) << steps, base.height()); ++v)
          for (std::int64_t u = x << steps; u < std::min((x + 1) << steps, base.width()); ++u)
            if (!base.is_void(u, v)) {
              count += 1.0;
              heights += base.at(u, v);
              least = std::min(least, base.at(u, v));
              greatest = std::max(greatest, base.at(u, v));
            }
        ASSERT_EQ(values.is_void(x, y), count == 0.0) << "level " << int{level.value} << ": " << x << "," << y;
        if (count == 0.0) continue;
        ASSERT_LE(bounds.at(x, y, 0), least);
        ASSERT_GE(bounds.at(x, y, 1), greatest);
        if (is_cut) continue;
        ASSERT_EQ(bounds.at(x, y, 0), least);
        ASSERT_EQ(bounds.at(x, y, 1), greatest);
        sum += count * values.at(x, y);
        finest_sum += heights;
        finest_count += count;
      }
    ASSERT_GT(finest_count, 0.0);
    // One rounding of floats a level, in sums of heights below 2^13: 2^-11 m of each texel at most, and not
    // all one way.
    EXPECT_NEAR(sum / finest_count, finest_sum / finest_count, 0x1p-11 * steps) << "level " << int{level.value};
  }
}

INSTANTIATE_TEST_SUITE_P(Files, RealTerrain,
                         ::testing::Values("swellendam_srtm_41_19_4326.tif", "everest_srtm_90m.tif", "mt_hood_lf_elev_220_utm.tif"));

// A void that no tag declares is a height to the filter; a height that no place has is said, with how many
// there are and where.
TEST(ElevationLayer, HeightsOfNowhereAreSaid) {
  const test::TempFolder folder;
  RasterSpec spec = spec_of(300, 200);
  for (const SampleType type : {SampleType::kFloat32, SampleType::kInt16, SampleType::kFloat64}) {
    spec.type = type;
    spec.nodata.reset();
    write_raster(folder / "input.tif", spec, [](std::int64_t x, std::int64_t y, int) {
      return x == 250 && y < 100 ? -32767.0 : x == 3 && y == 150 ? 9001.0 : x == 4 ? 9000.0 : x == 5 ? -12000.0 : terrain(x, y);
    });
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kElevation);
    const auto path = folder / (std::string(sample_name(type)) + ".vts");
    const BuildReport report = build(path, request, {.block_levels = 1});
    ASSERT_EQ(report.remarks.size(), 1U) << sample_name(type);
    EXPECT_NE(report.remarks[0].find("in 101 texels of the finest level (first in 250,0) the height is below -12000 m or above 9000 m"),
              std::string::npos)
        << report.remarks[0];
    const auto metadata = nlohmann::json::parse(store::StoreReader::open(path)->find_layer("elevation")->metadata_json);
    EXPECT_EQ(metadata.at("losses")[0].at("texels"), 101);
  }
  spec.type = SampleType::kFloat32;
  spec.nodata = -32767.0;
  write_raster(folder / "input.tif", spec, [](std::int64_t x, std::int64_t y, int) { return x == 250 ? -32767.0 : terrain(x, y); });
  LayerRequest declared = request_for({folder / "input.tif"}, ChannelType::kElevation);
  declared.name = "declared";
  EXPECT_TRUE(build(folder / "b.vts", declared).remarks.empty()) << "no data is no height";
}

}  // namespace
}  // namespace vt::pipeline
