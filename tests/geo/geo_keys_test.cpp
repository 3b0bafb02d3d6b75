#include "builder/geo/geo_keys.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace vt::geo {
namespace {

void expect_same(const CrsDefinition& a, const CrsDefinition& b) {
  EXPECT_EQ(a.projection.index(), b.projection.index());
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.epsg, b.epsg);
  EXPECT_EQ(a.datum, b.datum);
  EXPECT_EQ(a.datum_epsg, b.datum_epsg);
  EXPECT_EQ(a.ellipsoid.name, b.ellipsoid.name);
  EXPECT_EQ(a.ellipsoid.semi_major_m, b.ellipsoid.semi_major_m);
  EXPECT_EQ(a.ellipsoid.inverse_flattening, b.ellipsoid.inverse_flattening);
  std::visit(
      [&]<class Method>(const Method& method) {
        for (const Parameter<Method>& parameter : Method::parameters()) {
          const double written = method.*parameter.value;
          const double read = std::get<Method>(b.projection).*parameter.value;
          if (parameter.kind == ParameterKind::kLength) {
            EXPECT_NEAR(written, read, 1e-9 * std::abs(written)) << "through the grid's unit and back: " << parameter.label;
          } else {
            EXPECT_EQ(written, read) << parameter.label;
          }
        }
      },
      a.projection);
  EXPECT_EQ(a.metres_per_unit, b.metres_per_unit);
}

CrsDefinition local_grid() {
  CrsDefinition d;
  d.name = "Test range";
  d.datum = "Range datum";
  d.ellipsoid = {.name = "Range ellipsoid", .semi_major_m = 6378000.5, .inverse_flattening = 298.5};
  d.projection = TransverseMercator{.latitude_of_origin_deg = 47.123456789,
                                    .central_meridian_deg = 11.987654321,
                                    .scale_factor = 1.000023,
                                    .false_easting_m = 1000.25,
                                    .false_northing_m = -2000.5};
  return d;
}

TEST(GeoKeys, EveryKindOfCrsReadsBackAsWritten) {
  std::vector<Crs> systems = {Crs(), Crs(local_grid())};
  for (const int code : {4326, 4269, 4267, 4674, 32633, 32733, 31985, 2193, 3857, 26771, 31467, 6328, 3395, 5641, 3001, 6933})
    systems.push_back(Crs::from_epsg(code).value());
  CrsDefinition feet = local_grid();
  feet.metres_per_unit = 0.3048;
  systems.emplace_back(feet);
  CrsDefinition odd_unit = local_grid();
  odd_unit.metres_per_unit = 2.5;
  systems.emplace_back(odd_unit);
  CrsDefinition sphere = local_grid();
  sphere.ellipsoid = {.name = "Ball", .semi_major_m = 6371000.0, .inverse_flattening = 0.0};
  systems.emplace_back(sphere);
  CrsDefinition mercator = local_grid();
  mercator.projection = Mercator{.central_meridian_deg = 12.5, .scale_factor = 0.997, .false_easting_m = 250.0};
  systems.emplace_back(mercator);
  mercator.projection = Mercator{.central_meridian_deg = -72.5, .standard_parallel_deg = 33.25, .false_northing_m = -1.5};
  mercator.metres_per_unit = 0.3048;
  systems.emplace_back(mercator);
  CrsDefinition equal_area = local_grid();
  equal_area.projection = CylindricalEqualArea{.central_meridian_deg = 12.5, .standard_parallel_deg = 45.0, .false_easting_m = 250.0};
  systems.emplace_back(equal_area);
  CrsDefinition geographic;
  geographic.projection = Geographic{};
  geographic.name = geographic.datum = "Range datum";
  geographic.ellipsoid = local_grid().ellipsoid;
  systems.emplace_back(geographic);
  for (const Crs& system : systems) {
    SCOPED_TRACE(system.text());
    const GeoKeyMeaning meaning = crs_from_geo_keys(geo_keys_from_crs(system));
    ASSERT_TRUE(meaning.crs.has_value()) << meaning.problem;
    expect_same(system.definition(), meaning.crs->definition());
    EXPECT_TRUE(system.same_coordinates(*meaning.crs));
    EXPECT_FALSE(meaning.pixel_is_point);
  }
}

TEST(GeoKeys, NoKeysAreNoProblemAndNoCrs) {
  const GeoKeyMeaning meaning = crs_from_geo_keys({});
  EXPECT_FALSE(meaning.crs.has_value());
  EXPECT_TRUE(meaning.problem.empty());
}

// Numbers as files have them, and what messages say about them.
TEST(GeoKeys, WhatIsNotReadIsNamedByCodeNameAndMethod) {
  struct Case {
    std::vector<std::uint16_t> directory;
    std::string ascii;
    std::string declared;
    std::string problem;
  };
  const Case cases[] = {
      {{1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 2056}, "", "EPSG:2056", "EPSG:2056"},
      {{1, 1, 0, 3, 1024, 0, 1, 1, 1026, 34737, 27, 0, 3072, 0, 1, 26746},
       "NAD27 / California zone VI|",
       "EPSG:26746 \"NAD27 / California zone VI\"",
       "EPSG:26746"},
      {{1, 1, 0, 3, 1024, 0, 1, 2, 2048, 0, 1, 4326, 2051, 0, 1, 8903}, "", "EPSG:4326", "Greenwich"},
      {{1, 1, 0, 5, 1024, 0, 1, 1, 2048, 0, 1, 4267, 3072, 0, 1, 32767, 3074, 0, 1, 32767, 3075, 0, 1, 8},
       "",
       "a projected CRS of its own, method 8 (Lambert conformal conic with two parallels)",
       "method 8 (Lambert conformal conic with two parallels)"},
      {{1, 1, 0, 3, 1024, 0, 1, 1, 3073, 34737, 39, 0, 3075, 0, 1, 77},
       "ESRI PE String = PROJCS[\"Somewhere\",G|",
       "a projected CRS of its own \"Somewhere\", method 77",
       "method 77"},
      {{1, 1, 0, 2, 1024, 0, 1, 32767, 1026, 34737, 10, 0}, "site grid|", "a CRS of its own \"site grid\"", "model type 32767"},
      {{1, 1, 0, 1, 1024, 0, 1, 3}, "", "a geocentric CRS", "geocentric"},
      {{1, 1, 0, 2, 1024, 0, 1, 3, 2048, 0, 1, 4978}, "", "EPSG:4978", "geocentric"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.declared);
    GeoKeyTags tags;
    tags.directory = c.directory;
    tags.ascii = c.ascii;
    const GeoKeyMeaning meaning = crs_from_geo_keys(tags);
    EXPECT_FALSE(meaning.crs.has_value());
    EXPECT_EQ(meaning.declared, c.declared);
    EXPECT_NE(meaning.problem.find(c.problem), std::string::npos) << meaning.problem;
    EXPECT_EQ(meaning.problem.empty(), c.declared.empty()) << meaning.problem;
    EXPECT_EQ(meaning.problem.find("--"), std::string::npos) << "advice is the caller's: it knows the file";
  }
}

// Keys that say how samples lie, or only what kind of coordinates there are, leave it to the user to name the
// CRS.
TEST(GeoKeys, KeysThatNameNoCrsDeclareNone) {
  const std::vector<std::uint16_t> directories[] = {
      {1, 1, 0, 0},
      {1, 1, 0, 1, 1025, 0, 1, 2},
      {1, 1, 0, 2, 1025, 0, 1, 1, 1026, 34737, 12, 0},
      {1, 1, 0, 2, 1024, 0, 1, 1, 1025, 0, 1, 1},
      {1, 1, 0, 2, 1024, 0, 1, 32767, 1025, 0, 1, 1},
      {1, 1, 0, 3, 1024, 0, 1, 1, 2048, 0, 1, 32767, 3072, 0, 1, 32767},
  };
  for (const auto& directory : directories) {
    GeoKeyTags tags;
    tags.directory = directory;
    tags.ascii = "made by us||";
    const GeoKeyMeaning meaning = crs_from_geo_keys(tags);
    EXPECT_FALSE(meaning.crs.has_value());
    EXPECT_EQ(meaning.declared, "");
    EXPECT_EQ(meaning.problem, "");
  }
}

TEST(GeoKeys, DamagedDirectoriesNeitherCrashNorLie) {
  const GeoKeyTags good = geo_keys_from_crs(Crs(local_grid()));
  // Every prefix of every tag, each in a buffer of its own.
  for (std::size_t length = 0; length < good.directory.size(); ++length) {
    GeoKeyTags cut = good;
    cut.directory.resize(length);
    cut.directory.shrink_to_fit();
    static_cast<void>(crs_from_geo_keys(cut));
  }
  for (std::size_t length = 0; length < good.doubles.size(); ++length) {
    GeoKeyTags cut = good;
    cut.doubles.resize(length);
    cut.doubles.shrink_to_fit();
    const GeoKeyMeaning meaning = crs_from_geo_keys(cut);
    const auto* const grid = meaning.crs ? std::get_if<TransverseMercator>(&meaning.crs->definition().projection) : nullptr;
    EXPECT_TRUE(grid == nullptr || grid->scale_factor != good.doubles.back());  // the last one is gone, not read from beyond
  }
  for (std::size_t length = 0; length < good.ascii.size(); ++length) {
    GeoKeyTags cut = good;
    cut.ascii.resize(length);
    cut.ascii.shrink_to_fit();
    static_cast<void>(crs_from_geo_keys(cut));
  }
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    GeoKeyTags flipped = good;
    for (int flips = 0; flips < 3; ++flips)
      flipped.directory[random() % flipped.directory.size()] ^= static_cast<std::uint16_t>(1U << random() % 16);
    const GeoKeyMeaning meaning = crs_from_geo_keys(flipped);
    if (meaning.crs && meaning.crs->kind() != CrsKind::kPixel) {
      static_cast<void>(meaning.crs->lonlat_from_crs({.x = 1000.0, .y = 2000.0}));
      static_cast<void>(meaning.crs->metres_per_unit_at({.x = 1000.0, .y = 2000.0}));
    }
  }
}

}  // namespace
}  // namespace vt::geo
