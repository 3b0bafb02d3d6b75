// Every system that PROJ's positions are known for and that we know: positions, the way back, scales, JSON
// and GeoKeys. Skips without the test data.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>

#include "builder/geo/crs.h"
#include "builder/geo/geo_keys.h"

namespace vt::geo {
namespace {

// Methods as the EPSG registry calls them. Of each of them one system at least is known, and all that are
// known are right.
const std::set<std::string> kMethods = {"Transverse Mercator", "Popular Visualisation Pseudo Mercator", "Mercator (variant A)",
                                        "Mercator (variant B)", "Lambert Cylindrical Equal Area"};

constexpr double kPositionDeg = 1e-9;  // a tenth of a millimetre; PROJ's own inverse agrees with it within 1e-13
constexpr double kPositionM = 2e-6;    // PROJ's series, and seven decimals

nlohmann::json truth() {
  std::ifstream file(std::string(VT_TEST_DATA) + "/projections.json");
  return file ? nlohmann::json::parse(file) : nlohmann::json();
}

// Ground metres between two places that are close together.
double distance_m(const Ellipsoid& ellipsoid, Point2 a, Point2 b) {
  const Radii radii = radii_at(ellipsoid, (a.y + b.y) / 2);
  const double east_m = radii.transverse_m * std::cos((a.y + b.y) / 2 * kDegree) * (b.x - a.x) * kDegree;
  return std::hypot(east_m, radii.meridian_m * (b.y - a.y) * kDegree);
}

// Across 20 m, where the middle latitude is as good as an integral.
void expect_scale(const Crs& crs, Point2 at) {
  const double half = 10.0 / crs.definition().metres_per_unit;
  const auto place = [&](double x, double y) { return crs.unwrapped_lonlat_from_crs({at.x + x, at.y + y}).value(); };
  const Ellipsoid& ellipsoid = crs.definition().ellipsoid;
  const Point2 metres = crs.metres_per_unit_at(at).value();
  // Half a micrometre in 20 m, and differences of angles in doubles.
  EXPECT_NEAR(metres.x, distance_m(ellipsoid, place(-half, 0), place(half, 0)) / (2 * half), 1e-7 * metres.x);
  EXPECT_NEAR(metres.y, distance_m(ellipsoid, place(0, -half), place(0, half)) / (2 * half), 1e-7 * metres.y);
}

void expect_positions(const Crs& crs, const nlohmann::json& points) {
  const double turn = crs.turn().value_or(0.0);
  for (const nlohmann::json& point : points) {
    const Point2 lonlat{point[0], point[1]};
    const Point2 wanted{point[2], point[3]};
    const auto there = crs.crs_from_lonlat(lonlat);
    ASSERT_TRUE(there.has_value()) << there.error().message;
    const double tolerance = kPositionM / crs.definition().metres_per_unit;
    // Longitudes are not brought to one turn, x is not either.
    const double off = there->x - wanted.x;
    EXPECT_NEAR(turn > 0.0 ? std::remainder(off, turn) : off, 0.0, tolerance) << point;
    EXPECT_NEAR(there->y, wanted.y, tolerance) << point;
    const auto back = crs.lonlat_from_crs(wanted);
    ASSERT_TRUE(back.has_value()) << back.error().message;
    EXPECT_NEAR(std::remainder(back->x - lonlat.x, 360.0), 0.0, kPositionDeg) << point;
    EXPECT_NEAR(back->y, lonlat.y, kPositionDeg) << point;
    if (turn > 0.0) {
      EXPECT_NEAR(crs.x_of_greenwich() + turn * lonlat.x / 360.0, there->x, tolerance) << point;
    }
    expect_scale(crs, wanted);
  }
}

TEST(ProjectionTruth, EverySystemThatIsKnownLiesWhereProjPutsIt) {
  const nlohmann::json data = truth();
  if (data.is_null()) GTEST_SKIP() << "no test data at " << VT_TEST_DATA;
  std::set<std::string> met;
  for (const nlohmann::json& row : data["crs"]) {
    const int code = row["epsg"];
    SCOPED_TRACE("EPSG:" + std::to_string(code) + " " + row["name"].get<std::string>());
    const auto crs = Crs::from_epsg(code);
    if (!crs) continue;
    const std::string method = row["method"];
    EXPECT_TRUE(kMethods.contains(method)) << method << " is known: name it in kMethods";
    met.insert(method);
    EXPECT_EQ(crs->definition().name, row["name"]);
    EXPECT_EQ(crs->definition().datum_epsg, row["geographic_epsg"]);
    EXPECT_NEAR(crs->definition().metres_per_unit, row["metres_per_unit"].get<double>(), 1e-15);
    expect_positions(*crs, row["points"]);

    // Without its code all its parameters are written.
    CrsDefinition own = crs->definition();
    own.epsg = 0;
    const Crs unregistered(own);
    const GeoKeyMeaning keys = crs_from_geo_keys(geo_keys_from_crs(unregistered));
    ASSERT_TRUE(keys.crs.has_value()) << keys.problem;
    EXPECT_TRUE(keys.crs->same_coordinates(*crs));
    const auto json = Crs::from_json(nlohmann::json::parse(crs->to_json().dump()));
    ASSERT_TRUE(json.has_value()) << json.error().message;
    EXPECT_TRUE(json->same_coordinates(*crs));
    EXPECT_EQ(json->to_json(), crs->to_json());
  }
  EXPECT_EQ(met, kMethods);
}

// A parameter that differs is another system, whichever it is; one that JSON does not have is at its default.
TEST(ProjectionTruth, EveryParameterCountsAndIsKept) {
  for_each_method([]<class Method>(const Method& method) {
    SCOPED_TRACE(Method::kInfo.title);
    CrsDefinition definition;
    definition.projection = method;
    const Crs plain(definition);
    for (const Parameter<Method>& parameter : Method::parameters()) {
      SCOPED_TRACE(parameter.json_key);
      Method changed = method;
      changed.*parameter.value += 0.5;
      definition.projection = changed;
      const Crs other(definition);
      EXPECT_FALSE(plain.same_coordinates(other));
      EXPECT_TRUE(other.same_coordinates(other));
      nlohmann::json json = other.to_json();
      EXPECT_EQ(json[parameter.json_key], changed.*parameter.value);
      json.erase(parameter.json_key);
      const auto read = Crs::from_json(json);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      EXPECT_TRUE(read->same_coordinates(plain));
      // What is no number is never a place.
      changed.*parameter.value = NAN;
      definition.projection = changed;
      EXPECT_FALSE(Crs(definition).crs_from_lonlat({.x = 0.0, .y = 0.0}).has_value());
    }
  });
}

TEST(ProjectionTruth, MercatorHasAScaleOrAParallelAndItsOriginOnTheEquator) {
  const auto answer = [](const Mercator& parameters) {
    CrsDefinition definition;
    definition.projection = parameters;
    return Crs(definition).crs_from_lonlat({.x = 1.0, .y = 1.0});
  };
  EXPECT_TRUE(answer({.scale_factor = 0.9}).has_value());
  EXPECT_TRUE(answer({.standard_parallel_deg = 40.0}).has_value());
  EXPECT_NE(answer({.scale_factor = 0.9, .standard_parallel_deg = 40.0}).error().message.find("not both"), std::string::npos);
  EXPECT_NE(answer({.latitude_of_origin_deg = 5.0}).error().message.find("equator"), std::string::npos);
  EXPECT_FALSE(answer({.standard_parallel_deg = 90.0}).has_value());
}

// Snyder, 10-14 and 3-12, in long double; and the place, the other way.
TEST(ProjectionTruth, CylindricalEqualAreaIsItsClosedForm) {
  CrsDefinition definition;
  definition.projection = CylindricalEqualArea{.standard_parallel_deg = 30.0};
  const Crs crs(definition);
  const long double f = 1.0L / 298.257223563L;
  const long double e2 = f * (2.0L - f);
  const long double e = std::sqrt(e2);
  const long double degree = std::numbers::pi_v<long double> / 180.0L;
  const long double k0 = std::cos(30.0L * degree) / std::sqrt(1.0L - e2 / 4.0L);
  for (double latitude = -89.7; latitude < 89.8; latitude += 1.3) {
    const long double sine = std::sin(static_cast<long double>(latitude) * degree);
    const long double q = (1.0L - e2) * (sine / (1.0L - e2 * sine * sine) + std::atanh(e * sine) / e);
    const auto y = static_cast<double>(6378137.0L * q / (2.0L * k0));
    EXPECT_NEAR(crs.crs_from_lonlat({.x = 10.0, .y = latitude})->y, y, 1e-8);
    // A bit of y is more of a latitude towards the poles.
    const double tolerance_deg = 1e-13 / std::cos(latitude * kDegree) + 1e-13;
    EXPECT_NEAR(crs.lonlat_from_crs({.x = 0.0, .y = y})->y, latitude, tolerance_deg);
  }
  const double pole_y = crs.crs_from_lonlat({.x = 0.0, .y = 90.0})->y;
  EXPECT_TRUE(crs.lonlat_from_crs({.x = 0.0, .y = pole_y}).has_value());
  EXPECT_FALSE(crs.lonlat_from_crs({.x = 0.0, .y = pole_y + 1.0}).has_value());
}

// What stores of today keep, to the byte.
TEST(ProjectionTruth, JsonOfTodaysSystemsIsWhatItWas) {
  EXPECT_EQ(Crs::from_epsg(26771)->to_json().dump(),
            R"({"central_meridian_deg":-88.33333333333333,"datum":"NAD27","datum_epsg":4267,"ellipsoid":{"inverse_flattening":)"
            R"(294.9786982138982,"name":"Clarke 1866","semi_major_m":6378206.4},"epsg":26771,"false_easting_m":152400.3048006096,)"
            R"("false_northing_m":0.0,"latitude_of_origin_deg":36.666666666666664,"metres_per_unit":0.3048006096012192,)"
            R"("name":"NAD27 / Illinois East","projection":"transverse_mercator","scale_factor":0.999975})");
  EXPECT_EQ(Crs::from_epsg(3857)->to_json().dump(),
            R"({"central_meridian_deg":0.0,"datum":"WGS 84","datum_epsg":4326,"ellipsoid":{"inverse_flattening":298.257223563,)"
            R"("name":"WGS 84","semi_major_m":6378137.0},"epsg":3857,"false_easting_m":0.0,"false_northing_m":0.0,)"
            R"("latitude_of_origin_deg":0.0,"metres_per_unit":1.0,"name":"WGS 84 / Pseudo-Mercator","projection":"web_mercator",)"
            R"("scale_factor":1.0})");
}

}  // namespace
}  // namespace vt::geo
