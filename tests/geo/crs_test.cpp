// Projection mathematics against independent references: GeographicLib's exact transverse Mercator, meridian
// arcs by numerical integration, closed forms, and a few published positions.
#include "builder/geo/crs.h"

#include <gtest/gtest.h>

#include <GeographicLib/TransverseMercatorExact.hpp>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

namespace vt::geo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Crs crs(int code) {
  auto result = Crs::from_epsg(code);
  EXPECT_TRUE(result.has_value()) << code;
  return result.value();
}

TransverseMercator transverse_mercator_of(const CrsDefinition& definition) {
  const auto* const parameters = std::get_if<TransverseMercator>(&definition.projection);
  EXPECT_NE(parameters, nullptr) << definition.name;
  return parameters != nullptr ? *parameters : TransverseMercator{};
}

TEST(Crs, UtmAgreesWithTheExactTransverseMercatorWithinAMicrometre) {
  const GeographicLib::TransverseMercatorExact exact(6378137.0, 1.0 / 298.257223563, 0.9996);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> latitude(-84.0, 84.0);
  std::uniform_real_distribution<double> offset(-40.0, 40.0);  // series and exact formulas both
  for (int i = 0; i < 4000; ++i) {
    const int zone = 1 + i % 60;
    const bool south = i % 2 != 0;
    const double meridian = 6.0 * zone - 183.0;
    const Point2 place{.x = meridian + offset(random), .y = latitude(random)};
    const Crs utm = crs((south ? 32700 : 32600) + zone);
    double x = 0.0;
    double y = 0.0;
    exact.Forward(meridian, place.y, place.x, x, y);
    const auto ours = utm.crs_from_lonlat(place);
    ASSERT_TRUE(ours.has_value());
    EXPECT_NEAR(ours->x, x + 500000.0, 1e-6);
    EXPECT_NEAR(ours->y, y + (south ? 10000000.0 : 0.0), 1e-6);
    const auto back = utm.lonlat_from_crs(*ours);
    ASSERT_TRUE(back.has_value());
    EXPECT_NEAR(std::remainder(back->x - place.x, 360.0) * std::cos(place.y * kDegree), 0.0, 1e-11);  // a micrometre
    EXPECT_NEAR(back->y, place.y, 1e-11);
  }
}

// Length of the meridian from the equator: Simpson's rule over M(phi) in long double, independent of any
// series.
long double meridian_arc(long double a, long double inverse_flattening, long double latitude_rad) {
  const long double f = 1.0L / inverse_flattening;
  const long double e2 = f * (2.0L - f);
  const auto radius = [&](long double phi) {
    const long double s = std::sin(phi);
    return a * (1.0L - e2) / std::pow(1.0L - e2 * s * s, 1.5L);
  };
  constexpr int kSteps = 2000;  // error of order (pi / 2 / 2000)^4 * 1e6 m < 1e-6 m, in fact far less
  const long double h = latitude_rad / kSteps;
  long double sum = radius(0.0L) + radius(latitude_rad);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 0 ? 2.0L : 4.0L) * radius(h * static_cast<long double>(i));
  return sum * h / 3.0L;
}

TEST(Crs, NorthingOnTheCentralMeridianIsTheMeridianArc) {
  for (double latitude = -80.0; latitude <= 84.0; latitude += 4.0) {
    const long double arc =
        meridian_arc(6378137.0L, 298.257222101L, static_cast<long double>(latitude) * std::numbers::pi_v<long double> / 180.0L);
    const auto nztm = crs(2193).crs_from_lonlat({.x = 173.0, .y = latitude});
    ASSERT_TRUE(nztm.has_value());
    EXPECT_NEAR(nztm->x, 1600000.0, 1e-8);
    EXPECT_NEAR(nztm->y, static_cast<double>(10000000.0L + 0.9996L * arc), 1e-7);
  }
}

TEST(Crs, PublishedPositionsAreMet) {
  // EPSG guidance note 7-2, British National Grid: 50 30 00 N, 0 30 00 E is E 577274.99, N 69740.50, by a
  // truncated series whose error is some millimetres.
  const auto london = crs(27700).crs_from_lonlat({.x = 0.5, .y = 50.5});
  ASSERT_TRUE(london.has_value());
  EXPECT_NEAR(london->x, 577274.99, 0.015);
  EXPECT_NEAR(london->y, 69740.50, 0.015);
  // The same note, popular visualisation pseudo-Mercator: 24 22 54.433 N, 100 20 00 W.
  const auto web = crs(3857).crs_from_lonlat({.x = -(100.0 + 20.0 / 60.0), .y = 24.0 + 22.0 / 60.0 + 54.433 / 3600.0});
  ASSERT_TRUE(web.has_value());
  EXPECT_NEAR(web->x, -11169055.58, 0.006);
  EXPECT_NEAR(web->y, 2800000.00, 0.006);
}

TEST(Crs, WebMercatorIsItsClosedForm) {
  const Crs web = crs(3857);
  for (double latitude = -85.0; latitude <= 85.0; latitude += 1.25) {
    const auto p = web.crs_from_lonlat({.x = 12.5, .y = latitude});
    ASSERT_TRUE(p.has_value());
    // The other form of the same function, in long double.
    const long double phi = static_cast<long double>(latitude) * std::numbers::pi_v<long double> / 180.0L;
    const long double y = 6378137.0L * std::log(std::tan(std::numbers::pi_v<long double> / 4.0L + phi / 2.0L));
    EXPECT_NEAR(p->y, static_cast<double>(y), 1e-8);
    EXPECT_NEAR(p->x, 6378137.0 * 12.5 * kDegree, 1e-9);
    const auto back = web.lonlat_from_crs(*p);
    ASSERT_TRUE(back.has_value());
    EXPECT_NEAR(back->y, latitude, 1e-12);
    EXPECT_NEAR(back->x, 12.5, 1e-12);
  }
  EXPECT_FALSE(web.crs_from_lonlat({.x = 0.0, .y = 90.0}).has_value());
  EXPECT_TRUE(crs(900913).same_coordinates(web));
  EXPECT_TRUE(crs(3785).same_coordinates(web));
}

TEST(Crs, UnitsScaleCoordinates) {
  // NAD27 / Illinois East counts US survey feet; the false origin is 500000 of them.
  const Crs illinois = crs(26771);
  const auto origin = illinois.crs_from_lonlat({.x = -(88.0 + 20.0 / 60.0), .y = 36.0 + 40.0 / 60.0});
  ASSERT_TRUE(origin.has_value());
  EXPECT_NEAR(origin->x, 500000.0, 1e-6);
  EXPECT_NEAR(origin->y, 0.0, 1e-6);
  EXPECT_EQ(illinois.definition().metres_per_unit, 1200.0 / 3937.0);
}

TEST(Crs, GroundMetresPerUnitMatchFiniteDifferences) {
  struct Case {
    int code;
    Point2 lonlat;
  };
  for (const Case& c : {Case{4326, {20.0, 60.0}}, Case{32633, {17.5, 48.0}}, Case{3857, {-100.0, 52.0}}, Case{26771, {-87.6, 41.9}},
                        Case{4326, {0.0, 0.0}}}) {
    const Crs system = crs(c.code);
    const Point2 at = system.crs_from_lonlat(c.lonlat).value();
    const Ellipsoid& e = system.definition().ellipsoid;
    const double f = 1.0 / e.inverse_flattening;
    const double e2 = f * (2.0 - f);
    // Chord between two places 2 h apart, through geocentric coordinates.
    const auto geocentric = [&](Point2 crs_point) {
      const Point2 p = system.lonlat_from_crs(crs_point).value();
      const double n = e.semi_major_m / std::sqrt(1.0 - e2 * std::pow(std::sin(p.y * kDegree), 2));
      return std::array<double, 3>{n * std::cos(p.y * kDegree) * std::cos(p.x * kDegree),
                                   n * std::cos(p.y * kDegree) * std::sin(p.x * kDegree), n * (1.0 - e2) * std::sin(p.y * kDegree)};
    };
    const double h = c.code == 4326 ? 1e-3 : 100.0;
    const auto distance = [&](Point2 a, Point2 b) {
      const auto p = geocentric(a);
      const auto q = geocentric(b);
      return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    };
    const Point2 scale = system.metres_per_unit_at(at).value();
    // 200 m apart: curvature takes 4e-11 of a chord, positions are good to 1e-9 m.
    EXPECT_NEAR(scale.x, distance({at.x - h, at.y}, {at.x + h, at.y}) / (2 * h), 1e-8 * scale.x) << c.code;
    EXPECT_NEAR(scale.y, distance({at.x, at.y - h}, {at.x, at.y + h}) / (2 * h), 1e-8 * scale.y) << c.code;
  }
}

TEST(Crs, EveryListedFamilyHasTheRightMeridianAndDatum) {
  struct Row {
    int code;
    double meridian;
    bool south;
    int datum;
  };
  // The whole table was compared once with PROJ 9.1.1's copy of the registry (parameters, ellipsoid, datum:
  // all equal); these rows guard the seams. A first, a last and a middle zone of families, from the EPSG
  // registry.
  for (const Row& row :
       {Row{32601, -177, false, 4326}, Row{32660, 177, false, 4326},  Row{32733, 15, true, 4326},   Row{26901, -177, false, 4269},
        Row{26923, -45, false, 4269},  Row{26711, -117, false, 4267}, Row{25828, -15, false, 4258}, Row{25838, 45, false, 4258},
        Row{31965, -117, false, 4674}, Row{31976, -51, false, 4674},  Row{31977, -81, true, 4674},  Row{31985, -33, true, 4674},
        Row{6328, 171, false, 6318},   Row{3706, 171, false, 4759},   Row{3726, -69, false, 4759},  Row{2958, -81, false, 4617},
        Row{6329, 177, false, 6318},   Row{6330, -177, false, 6318},  Row{6348, -69, false, 6318},  Row{28355, 147, true, 4283},
        Row{7855, 147, true, 7844},    Row{3100, 141, false, 4612},   Row{23032, 9, false, 4230}}) {
    const CrsDefinition d = crs(row.code).definition();
    const TransverseMercator grid = transverse_mercator_of(d);
    EXPECT_EQ(grid.central_meridian_deg, row.meridian) << row.code;
    EXPECT_EQ(grid.false_northing_m, row.south ? 1e7 : 0.0) << row.code;
    EXPECT_EQ(grid.scale_factor, 0.9996) << row.code;
    EXPECT_EQ(grid.false_easting_m, 500000.0) << row.code;
    EXPECT_EQ(d.datum_epsg, row.datum) << row.code;
    EXPECT_EQ(d.epsg, row.code);
  }
}

// A step to the east is a small step in longitude, wherever the antimeridian is.
TEST(Crs, UnwrappedLongitudesDoNotJumpAtTheAntimeridian) {
  for (const int code : {32601, 32660, 32701, 32760, 2193, 32633}) {
    const Crs utm = crs(code);
    const TransverseMercator grid = transverse_mercator_of(utm.definition());
    const double meridian = grid.central_meridian_deg;
    double last = NAN;
    for (double easting = -200000.0; easting <= 1200000.0; easting += 10000.0) {
      const Point2 place{.x = easting + grid.false_easting_m - 500000.0, .y = grid.false_northing_m + 1000.0};
      const Point2 wrapped = utm.lonlat_from_crs(place).value();
      const Point2 unwrapped = utm.unwrapped_lonlat_from_crs(place).value();
      EXPECT_EQ(unwrapped.y, wrapped.y);
      EXPECT_EQ(std::remainder(unwrapped.x - wrapped.x, 360.0), 0.0);
      EXPECT_LE(std::abs(unwrapped.x - meridian), 7.0) << code;
      if (std::abs(wrapped.x - meridian) < 180.0) {
        EXPECT_EQ(unwrapped.x, wrapped.x) << "to the last bit";
      }
      EXPECT_TRUE(std::isnan(last) || unwrapped.x > last);
      last = unwrapped.x;
    }
  }
  EXPECT_EQ(crs(4326).unwrapped_lonlat_from_crs({.x = 539.5, .y = 10.0})->x, 539.5);
  EXPECT_NEAR(crs(3857).unwrapped_lonlat_from_crs({.x = -30056262.514183868, .y = 0.0})->x, -270.0, 1e-9);  // three quarters of a turn
}

TEST(Crs, OneTurnIsTheSamePlace) {
  EXPECT_EQ(crs(4326).turn(), 360.0);
  EXPECT_EQ(crs(4269).turn(), 360.0);
  EXPECT_NEAR(crs(3857).turn().value(), 40075016.68557849, 1e-7);
  EXPECT_EQ(crs(32601).turn(), std::nullopt);
  EXPECT_EQ(Crs().turn(), std::nullopt);
}

TEST(Crs, JsonKeepsEveryBit) {
  CrsDefinition d = crs(26771).definition();
  TransverseMercator grid = transverse_mercator_of(d);
  grid.central_meridian_deg = -88.333333333333329 + 1e-14;
  grid.false_easting_m = 0.1 + 0.2;
  d.projection = grid;
  const Crs before(d);
  const auto after = Crs::from_json(nlohmann::json::parse(before.to_json().dump()));
  ASSERT_TRUE(after.has_value()) << after.error().message;
  const CrsDefinition& e = after->definition();
  EXPECT_EQ(transverse_mercator_of(e).central_meridian_deg, grid.central_meridian_deg);
  EXPECT_EQ(transverse_mercator_of(e).false_easting_m, grid.false_easting_m);
  EXPECT_EQ(e.metres_per_unit, d.metres_per_unit);
  EXPECT_EQ(e.ellipsoid.inverse_flattening, d.ellipsoid.inverse_flattening);
  EXPECT_EQ(after->to_json(), before.to_json());
  EXPECT_TRUE(after->same_coordinates(before));

  EXPECT_FALSE(Crs::from_json(nlohmann::json::parse("[]")).has_value());
  nlohmann::json broken = before.to_json();
  broken["projection"] = "flat";
  EXPECT_FALSE(Crs::from_json(broken).has_value());
  broken = before.to_json();
  broken["ellipsoid"]["semi_major_m"] = -1.0;
  EXPECT_FALSE(Crs::from_json(broken).has_value());
  broken = before.to_json();
  broken["scale_factor"] = 0.0;
  EXPECT_FALSE(Crs::from_json(broken).has_value());
}

TEST(Crs, ValuesInJsonThatNobodyKnowsAreRefusedAndWordsArePassedOver) {
  const nlohmann::json known = crs(26771).to_json();
  nlohmann::json newer = known;
  newer["remark"] = "for people";
  ASSERT_TRUE(Crs::from_json(newer).has_value());
  EXPECT_EQ(Crs::from_json(newer)->to_json(), known);

  newer["azimuth_deg"] = 3.0;
  const auto turned = Crs::from_json(newer);
  ASSERT_FALSE(turned.has_value());
  EXPECT_EQ(turned.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(turned.error().message.find("\"azimuth_deg\""), std::string::npos) << turned.error().message;

  for (const char* value : {"[1.0, 2.0]", R"({"shift_m": 3.0})", "true", "null"}) {
    newer = known;
    newer["grid"] = nlohmann::json::parse(value);
    EXPECT_FALSE(Crs::from_json(newer).has_value()) << value;
  }

  newer = known;
  newer["ellipsoid"]["semi_median_m"] = 6378000.0;
  EXPECT_FALSE(Crs::from_json(newer).has_value());

  // Less than all is what older programs wrote.
  newer = known;
  newer.erase("datum_epsg");
  EXPECT_TRUE(Crs::from_json(newer).has_value());
}

TEST(Crs, TextNamesACodeOrPixel) {
  EXPECT_EQ(Crs::from_text("EPSG:32633")->definition().epsg, 32633);
  EXPECT_EQ(Crs::from_text("32633")->text(), "EPSG:32633 (WGS 84 / UTM zone 33N)");
  EXPECT_EQ(Crs::from_text("pixel")->kind(), CrsKind::kPixel);
  for (const char* bad : {"", "EPSG:", "EPSG:12x", "utm 33", "EPSG:99999999999999"}) {
    const auto result = Crs::from_text(bad);
    ASSERT_FALSE(result.has_value()) << bad;
    EXPECT_EQ(result.error().code, ErrorCode::kUsage);
  }
  const auto unknown = Crs::from_epsg(2056);
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(unknown.error().message.find("2056"), std::string::npos);
}

TEST(Crs, PlacesWithoutAnAnswerAreErrors) {
  const Crs utm = crs(32633);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Point2 p : {Point2{1e9, 0.0}, Point2{0.0, 1e9}, Point2{nan, 0.0}, Point2{0.0, nan}, Point2{INFINITY, 0.0}}) {
    const auto answer = utm.lonlat_from_crs(p);
    ASSERT_FALSE(answer.has_value());
    EXPECT_EQ(answer.error().code, ErrorCode::kInvalidData);
  }
  for (const Point2 p : {Point2{105.0, 0.0}, Point2{15.0, 91.0}, Point2{nan, 0.0}}) EXPECT_FALSE(utm.crs_from_lonlat(p).has_value());
  EXPECT_EQ(Crs().lonlat_from_crs({1.0, 1.0}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(Crs().crs_from_lonlat({1.0, 1.0}).error().code, ErrorCode::kUsage);
}

TEST(Crs, DatumsKeepCoordinatesApart) {
  EXPECT_TRUE(crs(32633).same_coordinates(crs(32633)));
  EXPECT_FALSE(crs(32633).same_coordinates(crs(32634)));
  EXPECT_FALSE(crs(32633).same_coordinates(crs(25833)));
  EXPECT_FALSE(crs(4326).same_coordinates(crs(4258)));
  EXPECT_FALSE(crs(4326).same_coordinates(Crs()));
  EXPECT_TRUE(crs(4326).same_coordinates(crs(4979)));
}

}  // namespace
}  // namespace vt::geo
