// Which CRS counts, and which coordinates are possible in it: silent guesses put rasters thousands of
// kilometres off.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/pipeline/small_builds.h"
#include "tests/support/raw_tiff.h"

namespace vt::pipeline {
namespace {

geo::Crs crs(int code) { return geo::Crs::from_epsg(code).value(); }

class SourcePlace : public testing::Test {
 protected:
  // A file of 64 x 64 samples; `keys` is the GeoKey directory.
  std::filesystem::path tiff(const std::vector<std::uint16_t>& keys, const geo::GeoTransform& t, const std::string& ascii = "") {
    test::RawTiff raw = test::RawTiff::grey(64, 64);
    if (!keys.empty()) raw.shorts(34735, keys);
    if (!ascii.empty()) raw.bytes(34737, 2, ascii);
    raw.doubles(34264, {t.x_column, t.x_row, 0, t.x0, t.y_column, t.y_row, 0, t.y0, 0, 0, 0, 0, 0, 0, 0, 1});
    return written(raw);
  }
  std::filesystem::path tiff_without_place(const std::vector<std::uint16_t>& keys) {
    test::RawTiff raw = test::RawTiff::grey(64, 64);
    raw.shorts(34735, keys);
    return written(raw);
  }
  std::filesystem::path written(test::RawTiff& raw) {
    const auto path = folder_ / ("a" + std::to_string(files_++) + ".tif");
    raw.write(path);
    return path;
  }
  static Error error_of(const LayerRequest& request) {
    auto plan = plan_layer(request, std::nullopt, 1 << 20);
    EXPECT_FALSE(plan.has_value());
    return plan ? Error{} : plan.error();
  }
  static std::vector<std::string> warnings_of(const LayerRequest& request) {
    auto plan = plan_layer(request, std::nullopt, 1 << 20);
    EXPECT_TRUE(plan.has_value()) << (plan ? "" : plan.error().message);
    return plan ? plan->warnings : std::vector<std::string>{};
  }
  static bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

  test::TempFolder folder_;
  int files_ = 0;
};

const std::vector<std::uint16_t> kStatePlane = {1, 1, 0, 3, 1024, 0, 1, 1, 1026, 34737, 27, 0, 3072, 0, 1, 26746};
const geo::GeoTransform kFeet{1577139.7, 195.5, 0.0, 634349.2, 0.0, -198.3};
const geo::GeoTransform kMetres{500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0};
const geo::GeoTransform kDegrees{10.0, 0.01, 0.0, 50.0, 0.0, -0.01};

TEST_F(SourcePlace, ACrsThatTheFileDeclaresIsNotOverruledThoughItIsUnknown) {
  LayerRequest request = request_for({tiff(kStatePlane, kFeet, "NAD27 / California zone VI|")}, ChannelType::kColor);
  for (const bool has_crs : {false, true}) {
    if (has_crs) request.sources[0].fallback_crs = request.crs = crs(32611);
    const Error error = error_of(request);
    EXPECT_EQ(error.code, ErrorCode::kUnsupported);
    for (const char* words : {"EPSG:26746", "NAD27 / California zone VI", "gdalwarp", "`source-crs`"})
      EXPECT_TRUE(has(error.message, words)) << error.message;
    EXPECT_FALSE(has(error.message, "EPSG:4326")) << "its coordinates are no degrees: " << error.message;
    EXPECT_EQ(has(error.message, "not taken for EPSG:32611"), has_crs) << error.message;
    EXPECT_EQ(has(error.message, "gdalwarp -t_srs EPSG:32611"), has_crs) << error.message;
  }
  // Who knows better says so, and is reminded.
  request.sources[0].crs = crs(32611);
  const auto warnings = warnings_of(request);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(has(warnings[0], "declared in EPSG:26746 \"NAD27 / California zone VI\", but taken to be in EPSG:32611")) << warnings[0];
}

TEST_F(SourcePlace, AKnownCrsOfTheFileIsPlacedByItself) {
  const auto path = tiff({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633}, kMetres);
  LayerRequest request = request_for({path}, ChannelType::kColor);
  request.crs = request.sources[0].fallback_crs = crs(32632);  // as --crs does
  auto plan = plan_layer(request, std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  const Point2 corner = crs(32632).crs_from_lonlat(crs(32633).lonlat_from_crs({500000.0, 5000000.0}).value()).value();
  EXPECT_NEAR(plan->extent().west, corner.x, 30.0) << "resampled to where it is, not renamed";
  // Stated for the one file, it must not contradict.
  request.sources[0].stated_crs = crs(32632);
  const Error error = error_of(request);
  EXPECT_EQ(error.code, ErrorCode::kInvalidData);
  for (const char* words : {"EPSG:32633", "EPSG:32632", "source_crs"}) EXPECT_TRUE(has(error.message, words)) << error.message;
  request.sources[0].stated_crs = crs(32633);
  EXPECT_TRUE(plan_layer(request, std::nullopt, 1 << 20).has_value());
  // Overruled: warned when it differs, silent when it does not.
  request = request_for({path}, ChannelType::kColor);
  request.sources[0].crs = crs(32632);
  EXPECT_EQ(warnings_of(request).size(), 1U);
  request.sources[0].crs = crs(32633);
  EXPECT_EQ(warnings_of(request).size(), 0U);
}

TEST_F(SourcePlace, AFileThatDeclaresNoneTakesWhatIsGiven) {
  LayerRequest request = request_for({tiff({}, kMetres)}, ChannelType::kColor);
  for (const auto member : {&SourceRequest::crs, &SourceRequest::stated_crs, &SourceRequest::fallback_crs}) {
    request.sources[0].crs = request.sources[0].stated_crs = request.sources[0].fallback_crs = std::nullopt;
    request.sources[0].*member = crs(32633);
    EXPECT_EQ(warnings_of(request).size(), 0U);
  }
}

TEST_F(SourcePlace, TheAdviceForAFileWithoutACrsFitsItsCoordinates) {
  const Error metres = error_of(request_for({tiff({}, kMetres)}, ChannelType::kColor));
  EXPECT_EQ(metres.code, ErrorCode::kInvalidData);
  EXPECT_FALSE(has(metres.message, "EPSG:4326")) << metres.message;
  EXPECT_TRUE(has(metres.message, "`crs` EPSG:32633 for UTM zone 33 north")) << metres.message;
  EXPECT_TRUE(has(metres.message, "500000")) << metres.message;
  const Error degrees = error_of(request_for({tiff({}, kDegrees)}, ChannelType::kColor));
  EXPECT_TRUE(has(degrees.message, "`crs` EPSG:4326")) << degrees.message;
}

TEST_F(SourcePlace, DegreesAreDegrees) {
  const std::vector<std::uint16_t> wgs84 = {1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326};
  struct Case {
    geo::GeoTransform transform;
    std::string words;  // "": possible
  };
  const Case cases[] = {
      {kMetres, "look like metres"},
      {{10.0, 0.01, 0.0, 150.0, 0.0, -0.01}, "are no longitudes and latitudes"},
      {{10.0, 0.01, 0.0, -89.5, 0.0, -0.01}, "are no longitudes and latitudes"},  // down to -90.14
      {{545.0, 0.01, 0.0, 50.0, 0.0, -0.01}, "are no longitudes and latitudes"},
      {{-545.0, 0.01, 0.0, 50.0, 0.0, -0.01}, "are no longitudes and latitudes"},
      {{40.0, 0.01, 0.0, 170.0, 0.0, -0.01}, "exchanged"},
      {{-180.0, 5.625, 0.0, 90.0, 0.0, -2.8125}, ""},           // the globe
      {{-182.0, 5.7, 0.0, 91.0, 0.0, -2.84375}, ""},            // with samples on both poles
      {{500.0, 0.5, 0.0, 50.0, 0.0, -0.5}, ""},                 // up to 532
      {{-180.00125, 0.0025, 0.0, 90.00125, 0.0, -0.0025}, ""},  // samples on -180 and 90
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::Message() << c.transform.x0 << ", " << c.transform.y0);
    const LayerRequest request = request_for({tiff(wgs84, c.transform)}, ChannelType::kColor);
    if (c.words.empty()) {
      EXPECT_EQ(warnings_of(request).size(), 0U);
    } else {
      const Error error = error_of(request);
      EXPECT_EQ(error.code, ErrorCode::kInvalidData);
      EXPECT_TRUE(has(error.message, c.words)) << error.message;
      EXPECT_TRUE(has(error.message, "EPSG:4326 (WGS 84)")) << error.message;
    }
  }
  // Whoever named the CRS is told the option that names another.
  EXPECT_TRUE(has(error_of(request_for({tiff(wgs84, kMetres)}, ChannelType::kColor)).message, "`source-crs`"));
  LayerRequest request = request_for({tiff({}, kMetres)}, ChannelType::kColor);
  request.sources[0].fallback_crs = crs(4326);
  EXPECT_TRUE(has(error_of(request).message, "with `crs` EPSG:nnnn")) << error_of(request).message;
}

TEST_F(SourcePlace, ProjectedCoordinatesAreSomewhereOnTheEarth) {
  const std::vector<std::uint16_t> utm = {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633};
  const Error error = error_of(request_for({tiff(utm, {5e8, 10.0, 0.0, 5e6, 0.0, -10.0})}, ChannelType::kColor));
  EXPECT_EQ(error.code, ErrorCode::kInvalidData);
  EXPECT_TRUE(has(error.message, "lie nowhere on the Earth in EPSG:32633")) << error.message;
  const auto warnings = warnings_of(request_for({tiff(utm, kDegrees)}, ChannelType::kColor));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(has(warnings[0], "coordinates look like degrees, but EPSG:32633")) << warnings[0];
}

TEST_F(SourcePlace, AnExtentThatReplacesTheFilesOwnPlaceIsSaid) {
  LayerRequest request = request_for({tiff({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633}, kMetres)}, ChannelType::kColor);
  request.sources[0].extent = Area{500000.0, 4999360.0, 500640.0, 5000000.0};
  EXPECT_EQ(warnings_of(request).size(), 0U) << "the same place";
  request.sources[0].extent = Area{600000.0, 4999360.0, 600640.0, 5000000.0};
  const auto warnings = warnings_of(request);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(has(warnings[0], "a place of its own, which is not used: the extent")) << warnings[0];

  // A world file beside it counts likewise, whether it can be read or not.
  const std::filesystem::path bare = tiff_without_place({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633});
  LayerRequest beside = request_for({bare}, ChannelType::kColor);
  beside.sources[0].extent = Area{500000.0, 4999360.0, 500640.0, 5000000.0};
  EXPECT_EQ(warnings_of(beside).size(), 0U);
  for (const auto& [text, count] :
       {std::pair{"10 0 0 -10 500005 4999995", 0U}, std::pair{"10 0 0 -10 700005 4999995", 1U}, std::pair{"10 0 what", 1U}}) {
    std::ofstream(std::filesystem::path(bare).replace_extension(".tfw")) << text;
    const auto remarks = warnings_of(beside);
    ASSERT_EQ(remarks.size(), count) << text;
    if (count > 0) {
      EXPECT_TRUE(has(remarks[0], "a place of its own, which is not used: the extent")) << remarks[0];
    }
  }
}

TEST_F(SourcePlace, AMosaicNamesTheFileThatStrays) {
  const auto row_of = [&](std::size_t count) {
    std::vector<std::filesystem::path> paths;
    for (std::size_t i = 0; i < count; ++i) {
      geo::GeoTransform t = kMetres;
      t.x0 += 640.0 * static_cast<double>(i);
      paths.push_back(tiff({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633}, t));
    }
    return paths;
  };
  EXPECT_EQ(warnings_of(request_for(row_of(5), ChannelType::kColor)).size(), 0U);
  const std::vector<std::uint16_t> utm = {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633};
  for (const std::size_t others : {1U, 5U}) {
    SCOPED_TRACE(others);
    // Far away: a wrong zone, a digit too much.
    auto paths = row_of(others);
    paths.insert(paths.begin() + 1, tiff(utm, {500000.0, 10.0, 0.0, 9000000.0, 0.0, -10.0}));
    auto warnings = warnings_of(request_for(paths, ChannelType::kColor));
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_TRUE(warnings[0].starts_with(paths[1].string() + ": lies at")) << warnings[0];
    EXPECT_TRUE(has(warnings[0], "EPSG:32633")) << warnings[0];
    // A thousand times as large: millimetres or kilometres for metres.
    paths[1] = tiff(utm, {480000.0, 10000.0, 0.0, 5100000.0, 0.0, -10000.0});
    warnings = warnings_of(request_for(paths, ChannelType::kColor));
    ASSERT_GE(warnings.size(), 1U);
    EXPECT_TRUE(has(warnings[0], paths[1].string() + ": its samples are 1000 times as large as")) << warnings[0];
  }
  // So far that no store could hold the layer: the error says which file it is.
  auto paths = row_of(3);
  for (auto& path : paths) path = tiff(utm, {500000.0, 0.001, 0.0, 5000000.0, 0.0, -0.001});
  paths.push_back(tiff(utm, {500000.0, 0.001, 0.0, 9000000.0, 0.0, -0.001}));
  const Error error = error_of(request_for(paths, ChannelType::kColor));
  EXPECT_TRUE(has(error.message, "2^31")) << error.message;
  EXPECT_TRUE(has(error.message, "the reason may be this file: " + paths[3].string())) << error.message;
}

TEST_F(SourcePlace, AllBadFilesAreListedTogether) {
  std::vector<std::filesystem::path> paths;
  for (int i = 0; i < 30; ++i) {
    paths.push_back(folder_ / ("bad" + std::to_string(100 + i) + ".tif"));
    std::ofstream(paths.back()) << "nothing of use";
    if (i % 3 == 0) paths.push_back(tiff({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633}, kMetres));
  }
  const Error error = error_of(request_for(paths, ChannelType::kColor));
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_TRUE(has(error.message, "30 of 40 sources cannot be used")) << error.message;
  EXPECT_TRUE(has(error.message, "bad100.tif")) << error.message;
  EXPECT_TRUE(has(error.message, "bad119.tif")) << error.message;
  EXPECT_FALSE(has(error.message, "bad120.tif")) << error.message;
  EXPECT_TRUE(has(error.message, "and 10 more")) << error.message;
  // One alone is told alone.
  EXPECT_FALSE(has(error_of(request_for({paths[0]}, ChannelType::kColor)).message, "\n"));
}

TEST_F(SourcePlace, SeveralBandsAreNoHeightUntilOneIsChosen) {
  const auto grey = tiff({1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633}, kMetres);
  EXPECT_TRUE(plan_layer(request_for({grey}, ChannelType::kElevation), std::nullopt, 1 << 20).has_value());
  for (const ChannelType channel : {ChannelType::kElevation, ChannelType::kMaterial, ChannelType::kMask}) {
    for (const int bands : {2, 3, 4}) {
      const auto path = folder_ / "bands.tif";
      write_raster(path, {.width = 8, .height = 8, .bands = bands}, [](auto, auto, int band) { return band; });
      LayerRequest request = request_for({path}, channel);
      const Error error = error_of(request);
      EXPECT_EQ(error.code, ErrorCode::kInvalidData);
      EXPECT_TRUE(has(error.message, "has " + std::to_string(bands) + " bands of values")) << error.message;
      EXPECT_TRUE(has(error.message, "`bands` 1")) << error.message;
      request.sources[0].bands = {bands};
      EXPECT_TRUE(plan_layer(request, std::nullopt, 1 << 20).has_value());
    }
    // Grey with coverage is one value.
    write_raster(folder_ / "alpha.tif", {.width = 8, .height = 8, .bands = 2, .alpha = true}, [](auto, auto, int) { return 255; });
    EXPECT_TRUE(plan_layer(request_for({folder_ / "alpha.tif"}, channel), std::nullopt, 1 << 20).has_value());
  }
}

}  // namespace
}  // namespace vt::pipeline
