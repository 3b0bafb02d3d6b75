// The tags that place a TIFF, written by hand: what they mean, and what is said of those that mean nothing
// certain.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "builder/source/raster_source.h"
#include "tests/support/raw_tiff.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

constexpr std::uint16_t kScale = 33550;
constexpr std::uint16_t kTies = 33922;
constexpr std::uint16_t kMatrix = 34264;
constexpr std::uint16_t kRpc = 50844;

class TiffPlaceTest : public testing::Test {
 protected:
  RasterInfo info_of(const test::RawTiff& tiff) {
    tiff.write(folder_ / "a.tif");
    const auto source = open_raster(folder_ / "a.tif");
    EXPECT_TRUE(source.has_value()) << (source ? "" : source.error().message);
    return (*source)->info();
  }
  // Tie points of an affine map, moved by up to `noise` samples each.
  static std::vector<double> ties_of(const geo::GeoTransform& map, const std::vector<Point2>& places, double noise = 0.0) {
    std::vector<double> numbers;
    std::mt19937 random(5);
    for (const Point2& place : places) {
      const double angle = static_cast<double>(random() % 628) / 100.0;
      const Point2 crs = map.crs_from_raster({place.x + noise * std::cos(angle), place.y + noise * std::sin(angle)});
      for (const double number : {place.x, place.y, 0.0, crs.x, crs.y, 0.0}) numbers.push_back(number);
    }
    return numbers;
  }
  static void expect_near(const geo::GeoTransform& a, const geo::GeoTransform& b) {
    for (const Point2 place : {Point2{0, 0}, Point2{64, 0}, Point2{0, 64}, Point2{64, 64}}) {
      EXPECT_NEAR(a.crs_from_raster(place).x, b.crs_from_raster(place).x, 1e-6);
      EXPECT_NEAR(a.crs_from_raster(place).y, b.crs_from_raster(place).y, 1e-6);
    }
  }
  test::TempFolder folder_;
};

const std::vector<Point2> kSix = {{0, 0}, {64, 0}, {0, 64}, {64, 64}, {32, 32}, {16, 48}};

TEST_F(TiffPlaceTest, TiePointsThatLieOnAGridAreThatGridExactly) {
  const geo::GeoTransform grid{500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0};
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  tiff.crs(32633);
  tiff.doubles(kTies, ties_of(grid, kSix));
  const RasterInfo info = info_of(tiff);
  ASSERT_TRUE(info.has_transform) << info.place_problem;
  EXPECT_EQ(info.transform.x0, grid.x0);
  EXPECT_EQ(info.transform.x_column, grid.x_column);
  EXPECT_EQ(info.transform.x_row, 0.0);
  EXPECT_EQ(info.transform.y0, grid.y0);
  EXPECT_EQ(info.transform.y_column, 0.0);
  EXPECT_EQ(info.transform.y_row, grid.y_row);
  EXPECT_TRUE(info.unused.empty());
}

TEST_F(TiffPlaceTest, TiePointsOfARotatedGridPlaceToo) {
  const geo::GeoTransform grid{500000.0, 8.0, 6.0, 5000000.0, 6.0, -8.0};
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  tiff.doubles(kTies, ties_of(grid, kSix));
  RasterInfo info = info_of(tiff);
  ASSERT_TRUE(info.has_transform) << info.place_problem;
  expect_near(info.transform, grid);
  // Numbers of few digits are no reason to refuse, nor to rotate what is not rotated.
  tiff.doubles(kTies, ties_of({500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0}, kSix, 0.0003));
  info = info_of(tiff);
  ASSERT_TRUE(info.has_transform) << info.place_problem;
  EXPECT_TRUE(info.transform.is_north_up());
  EXPECT_NEAR(info.transform.x_column, 10.0, 1e-3);
}

TEST_F(TiffPlaceTest, ThePointOfATiePointIsASampleCentreWhereTheKeysSaySo) {
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  tiff.shorts(34735, {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, 32633});
  tiff.doubles(kTies, ties_of({500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0}, kSix));
  const RasterInfo info = info_of(tiff);
  EXPECT_EQ(info.transform.x0, 499995.0);
  EXPECT_EQ(info.transform.y0, 5000005.0);
}

TEST_F(TiffPlaceTest, TiePointsThatPlaceNothingForCertainAreNamed) {
  const geo::GeoTransform grid{500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0};
  struct Case {
    std::vector<double> ties;
    std::string words;
  };
  const Case cases[] = {
      {ties_of(grid, {{0, 0}}), "one tie point (tag 33922) without a sample size (tag 33550)"},
      {ties_of(grid, {{0, 0}, {64, 0}, {0, 64}}), "3 tie points (tag 33922) without a sample size"},
      {ties_of(grid, {{0, 0}, {16, 16}, {32, 32}, {64, 64}}), "4 tie points (tag 33922) lie on one line"},
      {ties_of(grid, kSix, 0.3), "6 tie points (tag 33922) do not lie on one grid: the nearest one misses them by up to 0."},
      {ties_of(grid, kSix, 200.0), "gdalwarp"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.words);
    test::RawTiff tiff = test::RawTiff::grey(64, 64);
    tiff.doubles(kTies, c.ties);
    const RasterInfo info = info_of(tiff);
    EXPECT_FALSE(info.has_transform);
    EXPECT_NE(info.place_problem.find(c.words), std::string::npos) << info.place_problem;
  }
  test::RawTiff zero = test::RawTiff::grey(64, 64);
  zero.doubles(kScale, {0.0, 0.0, 0.0});
  zero.doubles(kTies, ties_of(grid, {{0, 0}}));
  EXPECT_NE(info_of(zero).place_problem.find("one tie point"), std::string::npos);
  test::RawTiff size_alone = test::RawTiff::grey(64, 64);
  size_alone.doubles(kScale, {10.0, 10.0, 0.0});
  EXPECT_NE(info_of(size_alone).place_problem.find("without a tie point"), std::string::npos);
  test::RawTiff line = test::RawTiff::grey(64, 64);
  line.doubles(kMatrix, {1, 2, 0, 0, 2, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
  EXPECT_NE(info_of(line).place_problem.find("on one line"), std::string::npos);
  test::RawTiff rpc = test::RawTiff::grey(64, 64);
  rpc.doubles(kRpc, std::vector<double>(92, 1.0));
  EXPECT_NE(info_of(rpc).place_problem.find("gdalwarp -rpc"), std::string::npos);
  EXPECT_EQ(info_of(test::RawTiff::grey(64, 64)).place_problem, "");
}

// A miss is told in samples, as measured by the definition: the worst distance to the best affine map.
TEST_F(TiffPlaceTest, TheMissOfTiePointsIsInSamples) {
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  // Four corners of a square of 64, one of them moved by 10 units: the least squares plane leaves a quarter
  // of it at every corner, and its samples are 10 + 5 / 64 units wide.
  tiff.doubles(kTies, {0, 0, 0, 0, 0, 0, 64, 0, 0, 640, 0, 0, 0, 64, 0, 0, -640, 0, 64, 64, 0, 650, -640, 0});
  EXPECT_NE(info_of(tiff).place_problem.find("by up to 0.248 samples"), std::string::npos) << info_of(tiff).place_problem;
}

TEST_F(TiffPlaceTest, ANegativeScaleYIsTakenAsNorthUpAndSaid) {
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  tiff.crs(32633);
  tiff.doubles(kScale, {10.0, -10.0, 0.0});
  tiff.doubles(kTies, {0, 0, 0, 500000, 5000000, 0});
  RasterInfo info = info_of(tiff);
  EXPECT_EQ(info.transform.y_row, -10.0);
  ASSERT_EQ(info.unused.size(), 1U);
  EXPECT_NE(info.unused[0].what.find("a negative ScaleY (tag 33550)"), std::string::npos);
  EXPECT_NE(info.unused[0].instead.find("GTIFF_HONOUR_NEGATIVE_SCALEY"), std::string::npos) << "how to have it the other way";
  tiff.doubles(kScale, {10.0, 10.0, 0.0});
  EXPECT_TRUE(info_of(tiff).unused.empty());
}

TEST_F(TiffPlaceTest, TiePointsThatContradictTheSampleSizeAreSaid) {
  test::RawTiff tiff = test::RawTiff::grey(64, 64);
  tiff.doubles(kScale, {10.0, 10.0, 0.0});
  tiff.doubles(kTies, {0, 0, 0, 500000, 5000000, 0, 64, 64, 0, 500640, 4999360, 0});
  EXPECT_TRUE(info_of(tiff).unused.empty());
  tiff.doubles(kTies, {0, 0, 0, 500000, 5000000, 0, 64, 64, 0, 501280, 4999360, 0});
  const RasterInfo info = info_of(tiff);
  EXPECT_EQ(info.transform.x0, 500000.0);
  EXPECT_EQ(info.transform.x_column, 10.0);
  ASSERT_EQ(info.unused.size(), 1U);
  EXPECT_NE(info.unused[0].what.find("contradict"), std::string::npos);
}

}  // namespace
}  // namespace vt::source
