// Where vtinspect says that values lie, and what it says of places without data: layers that vtbuild made of
// rasters whose values are their own places.
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/cli/picture_file.h"
#include "tests/cli/vtinspect/run.h"
#include "tests/pipeline/small_builds.h"
#include "tools/cli/cli_support.h"

namespace vt::test {
namespace {

using pipeline::RasterSpec;
using testing::AllOf;
using testing::HasSubstr;

class VtinspectPlaces : public VtinspectTest {
 protected:
  void build(const std::vector<std::string>& more, const std::string& input = "in.tif") const {
    std::filesystem::remove(directory_ / "s.vts");
    std::vector<std::string> arguments{"layer", input, "-o", "s.vts", "--progress", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = run_program(VT_VTBUILD, arguments, directory_.path());
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }
  [[nodiscard]] nlohmann::json sample(std::vector<std::string> where) const {
    where.insert(where.begin(), {"sample", "s.vts"});
    return run_json("vtinspect-sample", where);
  }
};

float float_at(const TiffFile& tiff, std::int64_t x, std::int64_t y) {
  float value = 0.0F;
  std::memcpy(&value, &tiff.samples[static_cast<std::size_t>(y * tiff.width + x) * sizeof value], sizeof value);
  return value;
}

// --- Longitude is a circle ------------------------------------------------------------------------------------------------------------

TEST_F(VtinspectPlaces, LongitudesAreTurnedIntoTheLayer) {
  struct Case {
    double west;
    std::vector<std::pair<std::string, double>> asked;  // and the longitude of the texel's centre, as the layer counts
  };
  for (const Case& c :
       {Case{-2.0, {{"359.5,0.5", -0.5}, {"-1.5,0.5", -1.5}, {"357.5,0.5", 357.5}, {"-3.5,0.5", 356.5}, {"719.5,0.5", -0.5}}},
        Case{0.0, {{"-10.5,0.5", 349.5}, {"349.5,0.5", 349.5}, {"0.5,0.5", 0.5}, {"-359.5,0.5", 0.5}}},
        Case{-180.0, {{"190.5,0.5", -169.5}, {"180,0.5", 179.5}, {"-180,0.5", -179.5}, {"540,0.5", -179.5}}}}) {
    const RasterSpec raster{
        .width = 360, .height = 4, .bands = 1, .type = SampleType::kFloat32, .transform = {c.west, 1.0, 0.0, 2.0, 0.0, -1.0}, .epsg = 4326};
    pipeline::write_raster(directory_ / "in.tif", raster, [&](std::int64_t x, auto, int) { return c.west + static_cast<double>(x) + 0.5; });
    build({"--channel", "elevation", "--tile", "64"});
    for (const auto& [asked, longitude] : c.asked) {
      const auto json = sample({"--lonlat=" + asked});
      EXPECT_EQ(json["value"][0], longitude) << asked << " in a layer from " << c.west;
      EXPECT_EQ(json["value_crs"][0], longitude) << asked;
    }
  }
  // A strip from 170 to 200 degrees east, and places that are in none of its turns.
  const RasterSpec strip{
      .width = 30, .height = 4, .bands = 1, .type = SampleType::kFloat32, .transform = {170.0, 1.0, 0.0, 2.0, 0.0, -1.0}, .epsg = 4326};
  pipeline::write_raster(directory_ / "in.tif", strip, [](std::int64_t x, auto, int) { return 170.5 + static_cast<double>(x); });
  build({"--channel", "elevation", "--tile", "64"});
  EXPECT_EQ(sample({"--lonlat=-165.5,0.5"})["value"][0], 194.5);
  for (const char* outside : {"--lonlat=0,0", "--lonlat=-155,0", "--lonlat=165,0"}) {
    const Outcome outcome = run({"sample", "s.vts", outside});
    EXPECT_EQ(outcome.exit_code, 2) << outside;
    EXPECT_THAT(outcome.err, HasSubstr("longitude about 170 .. 200")) << outside;
  }
}

TEST_F(VtinspectPlaces, AWebMercatorLayerAcrossTheAntimeridianHasBothSides) {
  const double degree_m = 6378137.0 * 3.14159265358979323846 / 180.0;
  const RasterSpec raster{.width = 40,
                          .height = 4,
                          .bands = 1,
                          .type = SampleType::kFloat32,
                          .transform = {160.0 * degree_m, degree_m, 0.0, 2.0 * degree_m, 0.0, -degree_m},
                          .epsg = 3857};
  pipeline::write_raster(directory_ / "in.tif", raster, [](std::int64_t x, auto, int) { return 160.5 + static_cast<double>(x); });
  build({"--channel", "elevation", "--tile", "64"});
  EXPECT_EQ(sample({"--lonlat=170.5,0.5"})["value"][0], 170.5);
  EXPECT_EQ(sample({"--lonlat=-170.5,0.5"})["value"][0], 189.5);
}

// --- Heights that are picked ----------------------------------------------------------------------------------------------------------

// Every value is the place that it belongs to, in metres from the west edge times 1000 plus metres from the
// north edge.
TEST_F(VtinspectPlaces, PickedHeightsAreWhereTheyWerePicked) {
  constexpr double kStep = 2.0;
  const RasterSpec raster{.width = 101, .height = 67, .bands = 1, .type = SampleType::kFloat32};
  pipeline::write_raster(directory_ / "in.tif", raster, [&](std::int64_t x, std::int64_t y, int) {
    return 1000.0 * (kStep * (static_cast<double>(x) + 0.5)) + kStep * (static_cast<double>(y) + 0.5);
  });
  for (const std::string kernel : {"point", "box"}) {
    const bool is_point = kernel == "point";
    build({"--channel", "elevation", "--kernel", kernel, "--tile", "8", "--bounds", "yes"});
    const auto info = run_json("vtinspect-info", {"info", "s.vts"});
    EXPECT_EQ(info["layers"][0]["point_sampled"], is_point);
    EXPECT_EQ(info["layers"][1]["name"], "elevation/bounds");
    EXPECT_EQ(info["layers"][1]["point_sampled"], false) << "bounds are those of whole texels";
    const int finest = info["layers"][0]["finest_level"];
    ASSERT_EQ(finest, 4);
    for (int level = 0; level <= finest; ++level) {
      const std::string level_text = std::to_string(level);
      ASSERT_EQ(run({"extract", "s.vts", "--layer", "elevation", "--level", level_text, "-o", "out.tif"}).exit_code, 0);
      const TiffFile tiff = read_tiff(directory_ / "out.tif");
      // Texels at the east and south edges of means hang over the data, whose mean lies further inside. Every
      // texel asked for is three processes, so a dozen of a row stand for all.
      for (std::int64_t x = 0; x < tiff.width - 1; x += 1 + tiff.width / 12) {
        const float value = float_at(tiff, x, 0);
        const double west_m = std::floor(static_cast<double>(value) / 1000.0);
        // The centre of the cell, by the file's own tags (PixelIsArea).
        EXPECT_NEAR(tiff.tie_point[3] + (static_cast<double>(x) + 0.5) * tiff.pixel_scale[0] - raster.transform.x0, west_m, 1e-6)
            << kernel << " level " << level << " column " << x;
        const auto json = sample({"--layer", "elevation", "--level", level_text, "--texel", std::to_string(x) + ",0"});
        EXPECT_EQ(json["value"][0].get<float>(), value);
        EXPECT_NEAR(json["crs"][0].get<double>() - raster.transform.x0, west_m, 1e-6);
        EXPECT_NEAR(raster.transform.y0 - json["crs"][1].get<double>(), static_cast<double>(value) - 1000.0 * west_m, 0.01);
        EXPECT_EQ(json["crs"], json["value_crs"]);
        // Asked for by its place, and by one a quarter of a texel to the east of it: it is the nearest.
        const double quarter = is_point ? 0.25 * tiff.pixel_scale[0] : 0.0;
        for (const double more : {0.0, quarter}) {
          const double u = (west_m + more) / (kStep * 101.0);
          const double v = 1.0 - (static_cast<double>(value) - 1000.0 * west_m) / (kStep * 67.0);
          const auto by_uv =
              sample({"--layer", "elevation", "--level", level_text, "--uv", cli::format_exact(u) + "," + cli::format_exact(v)});
          EXPECT_EQ(by_uv["texel"][0], x) << kernel << " level " << level << " u " << u;
        }
      }
    }
  }
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "elevation", "--level", "1", "--texel", "1,1"}).out, testing::Not(HasSubstr("sampled")));
}

// --- Heights that floats do not hold ---------------------------------------------------------------------------------------------------

TEST_F(VtinspectPlaces, CodesAreReadInDoublePrecision) {
  const RasterSpec raster{.width = 40, .height = 30, .bands = 1, .type = SampleType::kFloat64};
  pipeline::write_raster(directory_ / "in.tif", raster,
                         [](std::int64_t x, std::int64_t y, int) { return 1e6 + 0.001 * static_cast<double>(x + 40 * y); });
  build({"--channel", "elevation", "--format", "r16", "--range", "1000000,1000005", "--quantum", "0.001"});
  for (const int x : {0, 7, 31}) {
    const auto json = sample({"--layer", "elevation", "--texel", std::to_string(x) + ",2"});
    EXPECT_NEAR(json["value"][0].get<double>() - 1e6, 0.001 * (x + 80), 0.0005);
  }
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "elevation", "--texel", "31,2"}).out, HasSubstr("value     1000000.111"));
}

// --- Heights that fill voids ----------------------------------------------------------------------------------------------------------

TEST_F(VtinspectPlaces, FilledVoidsAreFilledWhereWholeTilesAreVoid) {
  const auto is_void = [](std::int64_t x, std::int64_t y) { return x >= 8 && x < 30 && y >= 8 && y < 20; };
  const RasterSpec raster{.width = 56, .height = 40, .bands = 1, .type = SampleType::kFloat32};
  pipeline::write_raster(directory_ / "in.tif", raster, [&](std::int64_t x, std::int64_t y, int) {
    return is_void(x, y) ? std::nan("") : 500.0 + static_cast<double>(x + y);
  });
  build({"--channel", "elevation", "--tile", "8", "--fill", "7"});
  const Outcome extracted = run({"extract", "s.vts", "-o", "out.tif"});
  ASSERT_EQ(extracted.exit_code, 0);
  EXPECT_THAT(extracted.err,
              HasSubstr("2 tiles of layer elevation, level 3 are absent; they are written as 7, with which voids are filled"));
  const TiffFile tiff = read_tiff(directory_ / "out.tif");
  for (std::int64_t y = 0; y < 40; ++y)
    for (std::int64_t x = 0; x < 56; ++x)
      ASSERT_EQ(float_at(tiff, x, y), is_void(x, y) ? 7.0F : 500.0F + static_cast<float>(x + y)) << x << ',' << y;
  const auto json = sample({"--texel", "18,12"});
  EXPECT_EQ(json["tile_present"], false);
  EXPECT_EQ(json["value"], nlohmann::json::array({7.0}));
  EXPECT_THAT(run({"sample", "s.vts", "--texel", "18,12"}).out, HasSubstr("value     7 m (its tile is absent: voids are filled)\n"));
  EXPECT_EQ(run({"compare", "s.vts", "in.tif"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "s.vts", "out.tif"}).exit_code, 0);
}

// --- Texels without data in GeoTIFFs --------------------------------------------------------------------------------------------------

TEST_F(VtinspectPlaces, ClassesWithoutDataAreGdalNodata) {
  for (const std::string format : {"r8", "r16"}) {
    const RasterSpec raster{.width = 40, .height = 40, .bands = 1, .nodata = 0.0};
    // The western half is void, whole tiles of it and a column of others.
    pipeline::write_raster(directory_ / "in.tif", raster,
                           [](std::int64_t x, auto, int) { return x < 20 ? 0.0 : 1.0 + static_cast<double>(x % 3); });
    build({"--channel", "material", "--tile", "16", "--format", format, "--no-data-class", format == "r8" ? "255" : "65535"});
    ASSERT_EQ(run({"extract", "s.vts", "-o", "out.tif"}).exit_code, 0);
    const TiffFile tiff = read_tiff(directory_ / "out.tif");
    EXPECT_EQ(tiff.bands, 1);
    EXPECT_EQ(tiff.nodata, format == "r8" ? "255" : "65535");
    for (std::int64_t y = 0; y < 40; ++y)
      for (std::int64_t x = 0; x < 40; ++x) {
        const double code =
            format == "r8" ? std::to_integer<int>(tiff.samples[static_cast<std::size_t>(y * 40 + x)]) : double{float_at(tiff, x, y)};
        ASSERT_EQ(code, x < 20 ? (format == "r8" ? 255.0 : 65535.0) : 1.0 + static_cast<double>(x % 3)) << x << ',' << y;
      }
  }
}

TEST_F(VtinspectPlaces, MasksAreZeroAndLightIsDarkWhereNothingIsKnown) {
  const RasterSpec raster{.width = 40, .height = 40, .bands = 1, .type = SampleType::kFloat32};
  const auto value = [](std::int64_t x, auto, int) { return x < 20 ? std::nan("") : 1.0; };
  pipeline::write_raster(directory_ / "in.tif", raster, value);
  build({"--channel", "mask", "--tile", "16", "--range", "0,1"});
  ASSERT_EQ(run({"extract", "s.vts", "-o", "out.tif"}).exit_code, 0);
  const TiffFile mask = read_tiff(directory_ / "out.tif");
  EXPECT_EQ(mask.nodata, "");
  for (std::int64_t x = 0; x < 40; ++x) ASSERT_EQ(float_at(mask, x, 5), x < 20 ? 0.0F : 1.0F) << x;

  RasterSpec light = raster;
  light.bands = 3;
  pipeline::write_raster(directory_ / "in.tif", light, value);
  build({"--channel", "illumination", "--tile", "16", "--format", "rgba16f"});
  ASSERT_EQ(run({"extract", "s.vts", "-o", "out.tif"}).exit_code, 0);
  const TiffFile tiff = read_tiff(directory_ / "out.tif");
  ASSERT_EQ(tiff.bands, 4);
  EXPECT_EQ(tiff.extra_samples, 3) << "floats are no RGB to TIFF; the last of them says how much is covered";
  EXPECT_EQ(tiff.nodata, "");
  for (std::int64_t x = 0; x < 40; ++x) {
    float coverage = -1.0F;
    std::memcpy(&coverage, &tiff.samples[static_cast<std::size_t>((5 * 40 + x) * 4 + 3) * sizeof coverage], sizeof coverage);
    ASSERT_EQ(coverage, x < 20 ? 0.0F : 1.0F) << x;
  }
}

// 0 was "no data" in the source, and is the mean of heights around it on a coarser level: there the file says
// NaN.
TEST_F(VtinspectPlaces, AMeanThatIsTheSourcesNodataIsNoHole) {
  const RasterSpec raster{.width = 16, .height = 16, .bands = 1, .type = SampleType::kInt16, .nodata = 0.0};
  pipeline::write_raster(directory_ / "in.tif", raster, [](std::int64_t x, std::int64_t y, int) {
    return x < 8 && y < 8 ? 0.0 : x % 2 == 0 ? -5.0 : 5.0;
  });
  build({"--channel", "elevation", "--tile", "4"});
  ASSERT_EQ(run({"extract", "s.vts", "-o", "out.tif"}).exit_code, 0);
  EXPECT_EQ(read_tiff(directory_ / "out.tif").nodata, "0");
  const Outcome coarser = run({"extract", "s.vts", "--level", "1", "-o", "out.tif"});
  ASSERT_EQ(coarser.exit_code, 0);
  EXPECT_THAT(coarser.err, HasSubstr("0 was the source's \"no data\" and is a value here"));
  const TiffFile tiff = read_tiff(directory_ / "out.tif");
  EXPECT_EQ(tiff.nodata, "nan");
  for (std::int64_t y = 0; y < 8; ++y)
    for (std::int64_t x = 0; x < 8; ++x) {
      const bool is_hole = x < 4 && y < 4;
      EXPECT_EQ(std::isnan(float_at(tiff, x, y)), is_hole) << x << ',' << y;
      EXPECT_EQ(float_at(tiff, x, y) == 0.0F, !is_hole) << x << ',' << y;
    }
}

}  // namespace
}  // namespace vt::test
