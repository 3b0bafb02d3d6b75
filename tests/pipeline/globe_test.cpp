// Longitude is a circle: sources and areas that count it otherwise, or that lie across the antimeridian, meet
// all the same. Truth is a function of the place on the ground.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/pipeline/layer_values.h"

namespace vt::pipeline {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// Smooth, and the same after a whole turn.
double height_at(double longitude_deg, double latitude_deg) {
  return 1000.0 + 100.0 * std::cos(longitude_deg * kDegree) + 50.0 * std::sin(2.0 * longitude_deg * kDegree) + 2.0 * latitude_deg;
}

// Bilinear interpolation misses a function by an eighth of its second derivative times the step's square, for
// each axis.
double bilinear_error(double step_deg) { return (100.0 + 4.0 * 50.0) * std::pow(step_deg * kDegree, 2) / 8.0; }

struct DegreeGrid {
  double west = 0.0;
  double north = 0.0;
  double step = 1.0;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

void write_degrees(const std::filesystem::path& path, const DegreeGrid& grid) {
  RasterSpec spec{.width = grid.width, .height = grid.height, .bands = 1, .type = SampleType::kFloat32};
  spec.transform = {grid.west, grid.step, 0.0, grid.north, 0.0, -grid.step};
  spec.epsg = 4326;
  write_raster(path, spec, [&](std::int64_t x, std::int64_t y, int) {
    return height_at(grid.west + (static_cast<double>(x) + 0.5) * grid.step, grid.north - (static_cast<double>(y) + 0.5) * grid.step);
  });
}

LayerPlan plan_of(const LayerRequest& request, const std::optional<DatasetFrame>& frame = std::nullopt) {
  auto plan = plan_layer(request, frame, std::size_t{8} << 20);
  EXPECT_TRUE(plan.has_value()) << (plan ? "" : plan.error().message);
  return *std::move(plan);
}

// Every texel of the finest level that `has_data` says has a value, and that value within `tolerance` of the
// truth; all others have none.
template <class HasData>
void expect_truth(const std::filesystem::path& store, const geo::Crs& crs, double tolerance, const HasData& has_data) {
  const Tiles tiles = tiles_of(store, "elevation");
  auto reader = store::StoreReader::open(store);
  ASSERT_TRUE(reader.has_value());
  const LayerInfo layer = *reader->find_layer("elevation");
  std::int64_t with_data = 0;
  for (std::int64_t y = 0; y < layer.data.height; ++y)
    for (std::int64_t x = 0; x < layer.data.width; ++x) {
      const Point2 place{layer.grid.origin_x + (static_cast<double>(x) + 0.5) * layer.grid.step_x,
                         layer.grid.origin_y - (static_cast<double>(y) + 0.5) * layer.grid.step_y};
      const Point2 lonlat = crs.lonlat_from_crs(place).value();
      const bool has_tile = tiles.contains({layer.finest, static_cast<std::uint32_t>(x >> 5), static_cast<std::uint32_t>(y >> 5)});
      const double found = has_tile ? texel_at<float, 1>(tiles, 5, layer.finest, x, y)[0] : NAN;
      if (!has_data(lonlat)) {
        EXPECT_TRUE(std::isnan(found)) << lonlat.x << ", " << lonlat.y << ": " << found;
        continue;
      }
      ++with_data;
      ASSERT_NEAR(found, height_at(lonlat.x, lonlat.y), tolerance) << lonlat.x << ", " << lonlat.y;
    }
  EXPECT_GT(with_data, 0);
}

constexpr double kFloatError = 1e-4;  // half a float's step at 1500
const auto everywhere = [](Point2) { return true; };

TEST(Globe, ASourceFromZeroTo360FillsAnAreaFromMinus180) {
  const test::TempFolder folder;
  // As atmospheric grids are: samples on the poles and on meridian 0.
  write_degrees(folder / "a.tif", {.west = -2.0, .north = 92.0, .step = 4.0, .width = 90, .height = 46});
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.area = Area{-180.0, -90.0, 180.0, 90.0};
  build(folder / "a.vts", request);
  expect_truth(folder / "a.vts", geo::Crs::from_epsg(4326).value(), kFloatError, everywhere);
}

TEST(Globe, ASourceFromMinus180FillsAnAreaFromZeroTo360) {
  const test::TempFolder folder;
  write_degrees(folder / "a.tif", {.west = -180.0, .north = 90.0, .step = 2.0, .width = 180, .height = 90});
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.area = Area{0.0, -90.0, 360.0, 90.0};
  build(folder / "a.vts", request);
  expect_truth(folder / "a.vts", geo::Crs::from_epsg(4326).value(), kFloatError, everywhere);
}

// Interpolation sees both sides of the seam, wherever it is: a repeated edge would be wrong by half a step, 2
// m here.
TEST(Globe, ResamplingLooksAcrossTheSeamOfAClosedSource) {
  const test::TempFolder folder;
  write_degrees(folder / "grid.tif", {.west = -180.0, .north = 90.0, .step = 1.25, .width = 4, .height = 4});
  for (const double west : {-180.0, -1.37, 0.0, 100.1}) {
    SCOPED_TRACE(west);
    write_degrees(folder / "a.tif", {.west = west, .north = 90.0, .step = 2.0, .width = 180, .height = 90});
    LayerRequest request = request_for({folder / "grid.tif", folder / "a.tif"}, ChannelType::kElevation);
    request.area = Area{-180.0, -80.0, 180.0, 80.0};
    std::filesystem::remove(folder / "a.vts");
    build(folder / "a.vts", request);
    expect_truth(folder / "a.vts", geo::Crs::from_epsg(4326).value(), kFloatError + bilinear_error(2.0), everywhere);
  }
}

TEST(Globe, APieceOfAGlobeComesIntoTheAreaByWholeTurns) {
  const test::TempFolder folder;
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  struct Case {
    double west;
    double width;
  };
  // Counted from 0 to 360; across the antimeridian by a little and by much; more than a turn away.
  for (const Case& c : {Case{200.0, 60.0}, Case{-182.0, 10.0}, Case{170.0, 40.0}, Case{-400.0, 20.0}}) {
    SCOPED_TRACE(c.west);
    write_degrees(folder / "a.tif",
                  {.west = c.west, .north = 30.0, .step = 2.0, .width = static_cast<std::int64_t>(c.width / 2.0), .height = 20});
    LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
    request.area = Area{-180.0, -10.0, 180.0, 30.0};
    std::filesystem::remove(folder / "a.vts");
    build(folder / "a.vts", request);
    expect_truth(folder / "a.vts", geographic, kFloatError, [&](Point2 lonlat) {
      const double from_west = lonlat.x - c.west - 360.0 * std::floor((lonlat.x - c.west) / 360.0);
      return from_west < c.width;
    });
  }
}

TEST(Globe, AnAreaWithWestOfEastLiesAcrossTheAntimeridian) {
  const test::TempFolder folder;
  write_degrees(folder / "a.tif", {.west = -180.0, .north = 90.0, .step = 2.0, .width = 180, .height = 90});
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.area = Area{170.0, -10.0, -160.0, 10.0};
  const LayerPlan plan = plan_of(request);
  EXPECT_EQ(plan.extent(), (Area{170.0, -10.0, 200.0, 10.0}));
  build(folder / "a.vts", request);
  expect_truth(folder / "a.vts", geo::Crs::from_epsg(4326).value(), kFloatError, everywhere);

  // Only where longitudes come again.
  write_raster(folder / "utm.tif", {.width = 8, .height = 8}, [](auto, auto, int) { return 1.0; });
  request = request_for({folder / "utm.tif"}, ChannelType::kColor);
  request.area = Area{500010.0, 5399990.0, 500000.0, 5400000.0};
  EXPECT_EQ(plan_layer(request, std::nullopt, 1 << 20).error().code, ErrorCode::kUsage);
}

TEST(Globe, AnExtentWithWestOfEastPlacesAPictureAcrossTheAntimeridian) {
  const test::TempFolder folder;
  source::GeoTiffSpec spec{.width = 20, .height = 10};
  auto writer = source::GeoTiffWriter::create(folder / "a.tif", spec);
  ASSERT_TRUE(writer.has_value() && writer->write_rows(std::vector<std::byte>(200), 10).has_value() && writer->finish().has_value());
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.sources[0].fallback_crs = geo::Crs::from_epsg(4326).value();
  request.sources[0].extent = Area{175.0, -5.0, -175.0, 0.0};
  EXPECT_EQ(plan_of(request).extent(), (Area{175.0, -5.0, 185.0, 0.0}));
  request.sources[0].fallback_crs = geo::Crs::from_epsg(32601).value();
  EXPECT_EQ(plan_layer(request, std::nullopt, 1 << 20).error().code, ErrorCode::kUsage);
}

TEST(Globe, TilesOnBothSidesOfTheAntimeridianMakeOneSmallLayer) {
  const test::TempFolder folder;
  write_degrees(folder / "E178.tif", {.west = 178.0, .north = -16.0, .step = 0.125, .width = 16, .height = 8});
  write_degrees(folder / "W180.tif", {.west = -180.0, .north = -16.0, .step = 0.125, .width = 8, .height = 8});
  const LayerRequest request = request_for({folder / "W180.tif", folder / "E178.tif"}, ChannelType::kElevation);
  EXPECT_EQ(plan_of(request).extent(), (Area{178.0, -17.0, 181.0, -16.0}));
  build(folder / "a.vts", request);
  expect_truth(folder / "a.vts", geo::Crs::from_epsg(4326).value(), kFloatError, everywhere);
}

// Layers that need no turn are asked for, remembered and built as ever.
TEST(Globe, SourcesThatLieWhereTheyShouldStayThere) {
  const test::TempFolder folder;
  write_degrees(folder / "globe.tif", {.west = -180.0, .north = 90.0, .step = 2.0, .width = 180, .height = 90});
  // A column more, as grids with samples on both -180 and 180 have.
  write_degrees(folder / "overhang.tif", {.west = -181.0, .north = 90.0, .step = 2.0, .width = 181, .height = 90});
  write_degrees(folder / "west.tif", {.west = -120.0, .north = 10.0, .step = 2.0, .width = 10, .height = 10});
  write_degrees(folder / "east.tif", {.west = 100.0, .north = 10.0, .step = 2.0, .width = 10, .height = 10});
  const auto settings_of = [&](const std::vector<std::string>& names) {
    std::vector<std::filesystem::path> inputs;
    for (const std::string& name : names) inputs.push_back(folder / name);
    return plan_of(request_for(inputs, ChannelType::kElevation)).settings.dump();
  };
  for (const std::vector<std::string>& names : {std::vector<std::string>{"globe.tif"}, {"overhang.tif"}, {"west.tif", "east.tif"}}) {
    const std::string settings = settings_of(names);
    EXPECT_EQ(settings.find("turns"), std::string::npos) << settings;
    EXPECT_EQ(settings.find("comes_again"), std::string::npos) << settings;
  }
  EXPECT_EQ(plan_of(request_for({folder / "overhang.tif"}, ChannelType::kElevation)).extent(), (Area{-181.0, -90.0, 181.0, 90.0}));
  EXPECT_EQ(plan_of(request_for({folder / "west.tif", folder / "east.tif"}, ChannelType::kElevation)).extent(),
            (Area{-120.0, -10.0, 120.0, 10.0}));
  // And a layer that does need one is another layer than the same command made without it.
  LayerRequest request = request_for({folder / "globe.tif"}, ChannelType::kElevation);
  request.area = Area{0.0, -90.0, 360.0, 90.0};
  EXPECT_NE(plan_of(request).settings.dump().find("comes_again"), std::string::npos);
  request = request_for({folder / "west.tif"}, ChannelType::kElevation);
  request.area = Area{200.0, -10.0, 300.0, 10.0};
  EXPECT_NE(plan_of(request).settings.dump().find("\"turns\":[1]"), std::string::npos);
}

TEST(Globe, ALayerComesIntoTheTurnOfItsStore) {
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  const test::TempFolder folder;
  write_degrees(folder / "globe.tif", {.west = 0.0, .north = 90.0, .step = 2.0, .width = 180, .height = 90});
  write_degrees(folder / "piece.tif", {.west = 200.0, .north = 10.0, .step = 2.0, .width = 10, .height = 10});
  write_degrees(folder / "across.tif", {.west = 170.0, .north = 10.0, .step = 2.0, .width = 10, .height = 10});
  const DatasetFrame store{geographic, Area{-180.0, -90.0, 180.0, 90.0}};
  const auto extent_of = [&](const char* name, const DatasetFrame& frame) {
    return plan_of(request_for({folder / name}, ChannelType::kElevation), frame).extent();
  };
  EXPECT_EQ(extent_of("globe.tif", store), (Area{-180.0, -90.0, 180.0, 90.0}));
  EXPECT_EQ(extent_of("piece.tif", store), (Area{-160.0, -10.0, -140.0, 10.0}));
  EXPECT_EQ(extent_of("across.tif", store), (Area{-180.0, -10.0, 180.0, 10.0}))
      << "it sticks out in the east and comes in again in the west";
  // The same for a store that is planned and not there yet.
  EXPECT_EQ(extent_of("globe.tif", DatasetFrame{geographic, std::nullopt, Area{-180.0, -90.0, 180.0, 90.0}}),
            (Area{-180.0, -90.0, 180.0, 90.0}));
  LayerRequest request = request_for({folder / "piece.tif"}, ChannelType::kElevation);
  request.area = Area{200.0, -10.0, 210.0, 10.0};
  EXPECT_EQ(plan_of(request, store).extent(), (Area{-160.0, -10.0, -150.0, 10.0}));
}

// Linear in easting and northing, so that bilinear interpolation is exact wherever the warp is.
TEST(Globe, UtmAcrossTheAntimeridianIsNoStripRoundTheGlobe) {
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  for (const int zone : {32601, 32660, 32760}) {
    SCOPED_TRACE(zone);
    const test::TempFolder folder;
    const geo::Crs utm = geo::Crs::from_epsg(zone).value();
    const Point2 centre = utm.crs_from_lonlat({180.0, zone > 32700 ? -17.0 : 52.0}).value();
    RasterSpec spec{.width = 100, .height = 80, .bands = 1, .type = SampleType::kFloat32};
    spec.transform = {centre.x - 5000.0, 100.0, 0.0, centre.y + 4000.0, 0.0, -100.0};
    spec.epsg = zone;
    const auto height = [&](Point2 place) { return 0.01 * (place.x - centre.x) + 0.02 * (place.y - centre.y); };
    write_raster(folder / "a.tif", spec, [&](std::int64_t x, std::int64_t y, int) {
      return height(spec.transform.crs_from_raster({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5}));
    });
    LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
    request.crs = geographic;
    const Area extent = plan_of(request).extent();
    EXPECT_LT(extent.east - extent.west, 0.2);
    build(folder / "a.vts", request);
    request.area = Area{-180.0, -60.0, 180.0, 60.0};  // the same in an area that it comes into from both sides
    request.gsd_m = 2000.0;
    build(folder / "globe.vts", request);
    for (const char* store : {"a.vts", "globe.vts"}) {
      Values values(folder / store, "elevation");
      const LayerInfo& layer = values.info();
      std::int64_t east = 0;
      std::int64_t west = 0;
      const auto raster_from_crs = spec.transform.inverse().value();
      for (std::int64_t y = 0; y < layer.data.height; ++y)
        for (std::int64_t x = 0; x < layer.data.width; ++x) {
          const Point2 lonlat{layer.grid.origin_x + (static_cast<double>(x) + 0.5) * layer.grid.step_x,
                              layer.grid.origin_y - (static_cast<double>(y) + 0.5) * layer.grid.step_y};
          const double from_line = std::remainder(lonlat.x - 180.0, 360.0);
          if (std::abs(from_line) > 1.0 || std::abs(lonlat.y - (zone > 32700 ? -17.0 : 52.0)) > 1.0) continue;
          const Point2 place = utm.crs_from_lonlat(lonlat).value();
          const Point2 raster = raster_from_crs.apply(place);
          if (raster.x < 1.0 || raster.x > 99.0 || raster.y < 1.0 || raster.y > 79.0) continue;
          // The warp may be a thousandth of a sample off, 0.1 m, and steps between lattice nodes are floats.
          ASSERT_NEAR(values.at(0, x, y)[0], height(place), 0.01) << lonlat.x << ", " << lonlat.y;
          ++(from_line < 0.0 ? west : east);
        }
      EXPECT_GT(west, 3) << store;
      EXPECT_GT(east, 3) << store;
    }
  }
}

// Round a pole every longitude is at home.
TEST(Globe, ARasterRoundAPoleHasAllLongitudes) {
  const test::TempFolder folder;
  const geo::Crs utm = geo::Crs::from_epsg(32633).value();
  const Point2 pole = utm.crs_from_lonlat({15.0, 90.0}).value();
  RasterSpec spec{.width = 80, .height = 80, .bands = 1, .type = SampleType::kFloat32};
  spec.transform = {pole.x - 40000.0, 1000.0, 0.0, pole.y + 40000.0, 0.0, -1000.0};
  const auto height = [&](Point2 place) { return 0.01 * (place.x - pole.x) + 0.02 * (place.y - pole.y); };
  write_raster(folder / "a.tif", spec, [&](std::int64_t x, std::int64_t y, int) {
    return height(spec.transform.crs_from_raster({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5}));
  });
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.crs = geo::Crs::from_epsg(4326).value();
  request.gsd_m = 1000.0;
  build(folder / "a.vts", request);
  Values values(folder / "a.vts", "elevation");
  const LayerInfo& layer = values.info();
  std::array<int, 4> quarters{};
  for (std::int64_t y = 0; y < layer.data.height; ++y)
    for (std::int64_t x = 0; x < layer.data.width; ++x) {
      const Point2 lonlat{layer.grid.origin_x + (static_cast<double>(x) + 0.5) * layer.grid.step_x,
                          layer.grid.origin_y - (static_cast<double>(y) + 0.5) * layer.grid.step_y};
      const Point2 place = utm.crs_from_lonlat(lonlat).value();
      if (std::abs(place.x - pole.x) > 39000.0 || std::abs(place.y - pole.y) > 39000.0) continue;
      ASSERT_NEAR(values.at(0, x, y)[0], height(place), 0.05) << lonlat.x << ", " << lonlat.y;  // a thousandth of a sample is 0.02
      ++quarters[static_cast<std::size_t>((place.x > pole.x ? 1 : 0) + (place.y > pole.y ? 2 : 0))];
    }
  for (const int count : quarters) EXPECT_GT(count, 100);
}

TEST(Globe, DegreesOfAnyTurnComeIntoAUtmZoneAtTheAntimeridian) {
  const test::TempFolder folder;
  const geo::Crs utm = geo::Crs::from_epsg(32601).value();
  const Point2 centre = utm.crs_from_lonlat({180.0, 10.0}).value();
  // Tiles that meet at the antimeridian, counted in either way; and one across it.
  const DegreeGrid west{.west = 179.0, .north = 11.0, .step = 0.0625, .width = 16, .height = 32};
  const DegreeGrid east{.west = -180.0, .north = 11.0, .step = 0.0625, .width = 16, .height = 32};
  const DegreeGrid east_counted_on{.west = 180.0, .north = 11.0, .step = 0.0625, .width = 16, .height = 32};
  const DegreeGrid across{.west = 179.0, .north = 11.0, .step = 0.0625, .width = 32, .height = 32};
  const DegreeGrid across_counted_down{.west = -181.0, .north = 11.0, .step = 0.0625, .width = 32, .height = 32};
  for (const std::vector<DegreeGrid>& grids :
       {std::vector{west, east}, std::vector{west, east_counted_on}, std::vector{across}, std::vector{across_counted_down}}) {
    std::vector<std::filesystem::path> inputs;
    for (const DegreeGrid& grid : grids) {
      inputs.push_back(folder / (std::to_string(inputs.size()) + ".tif"));
      write_degrees(inputs.back(), grid);
    }
    LayerRequest request = request_for(inputs, ChannelType::kElevation);
    request.crs = utm;
    request.gsd_m = 5000.0;
    request.area = Area{centre.x - 80000.0, centre.y - 80000.0, centre.x + 80000.0, centre.y + 80000.0};
    std::filesystem::remove(folder / "a.vts");
    build(folder / "a.vts", request);
    // Between two tiles the edge samples are repeated: half a sample of 1/16 degree, times the slope of at
    // most 2 m a degree.
    expect_truth(folder / "a.vts", utm, 0.1, everywhere);
  }
}

TEST(Globe, AWebMercatorLayerHasBothSidesOfTheAntimeridian) {
  const test::TempFolder folder;
  const geo::Crs mercator = geo::Crs::from_epsg(3857).value();
  write_degrees(folder / "a.tif", {.west = 170.0, .north = 20.0, .step = 1.0, .width = 20, .height = 40});
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.crs = mercator;
  request.gsd_m = 50000.0;
  const double half = *mercator.turn() / 2;
  request.area = Area{-half, -2e6, half, 2e6};
  build(folder / "a.vts", request);
  const double texel_deg = 360.0 * 50000.0 / *mercator.turn();
  expect_truth(folder / "a.vts", mercator, kFloatError + bilinear_error(1.0) + 1.0,
               [&](Point2 lonlat) { return std::abs(std::remainder(lonlat.x - 180.0, 360.0)) <= 10.0 && texel_deg < 1.0; });
}

// The whole Earth has no place in a UTM zone; what of it lies in the layer's area has.
TEST(Globe, AGlobalSourceFillsAnAreaOfAProjectedLayer) {
  const test::TempFolder folder;
  for (const int zone : {32633, 32601}) {
    SCOPED_TRACE(zone);
    for (const double west : {-180.0, 0.0}) {
      write_degrees(folder / "a.tif", {.west = west, .north = 90.0, .step = 0.5, .width = 720, .height = 360});
      const geo::Crs utm = geo::Crs::from_epsg(zone).value();
      LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
      request.crs = utm;
      request.gsd_m = 20000.0;
      request.area = Area{100000.0, 1000000.0, 900000.0, 2000000.0};
      std::filesystem::remove(folder / "a.vts");
      build(folder / "a.vts", request);
      expect_truth(folder / "a.vts", utm, kFloatError + bilinear_error(0.5) + 0.01, everywhere);
    }
  }
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
  request.crs = geo::Crs::from_epsg(32633).value();
  EXPECT_EQ(plan_layer(request, std::nullopt, 1 << 20).error().code, ErrorCode::kInvalidData) << "all of it has no place";
}

// x of a Mercator counts from its own meridian, here 150 degrees east: wherever the raster is cut, its
// samples lie at their longitudes.
TEST(Globe, AGlobeThatCountsFromAnotherMeridianFillsAnArea) {
  const test::TempFolder folder;
  const geo::Crs pacific = geo::Crs::from_epsg(3832).value();
  const double step = *pacific.turn() / 720;
  for (const double west : {-360.0 * step, -7.25 * step}) {
    RasterSpec spec{.width = 720, .height = 200, .bands = 1, .type = SampleType::kFloat32};
    spec.transform = {west, step, 0.0, 100.0 * step, 0.0, -step};
    spec.epsg = 3832;
    write_raster(folder / "a.tif", spec, [&](std::int64_t x, std::int64_t y, int) {
      const Point2 place{west + (static_cast<double>(x) + 0.5) * step, (99.5 - static_cast<double>(y)) * step};
      const Point2 lonlat = pacific.lonlat_from_crs(place).value();
      return height_at(lonlat.x, lonlat.y);
    });
    const auto expect_layer = [&](int code, const Area& area, double gsd_m) {
      SCOPED_TRACE(std::to_string(code) + " from " + std::to_string(west / step));
      const geo::Crs crs = geo::Crs::from_epsg(code).value();
      LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kElevation);
      request.crs = crs;
      request.gsd_m = gsd_m;
      request.area = area;
      std::filesystem::remove(folder / "a.vts");
      build(folder / "a.vts", request);
      expect_truth(folder / "a.vts", crs, kFloatError + bilinear_error(0.5) + 0.01, everywhere);
    };
    for (const int zone : {32633, 32601, 32654}) expect_layer(zone, {100000.0, 1000000.0, 900000.0, 2000000.0}, 20000.0);
    expect_layer(4326, {-180.0, -30.0, 180.0, 30.0}, 50000.0);
  }
}

}  // namespace
}  // namespace vt::pipeline
