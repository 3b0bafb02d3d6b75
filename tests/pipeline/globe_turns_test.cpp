#include "builder/pipeline/sources/globe_turns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace vt::pipeline {
namespace {

Bounds degrees(double west, double east) { return {west, -10.0, east, 10.0}; }

using Turns = std::vector<int>;

TEST(GlobeTurns, ABoxComesIntoAnAreaByTheTurnsThatOverlapIt) {
  EXPECT_EQ(turns_into(degrees(0, 360), degrees(-180, 180), 360), (Turns{0, -1}));
  EXPECT_EQ(turns_into(degrees(-180, 180), degrees(0, 360), 360), (Turns{0, 1}));
  EXPECT_EQ(turns_into(degrees(-180, 180), degrees(-180, 180), 360), (Turns{0})) << "edges that only meet have nothing in common";
  EXPECT_EQ(turns_into(degrees(200, 210), degrees(-180, 180), 360), (Turns{-1}));
  EXPECT_EQ(turns_into(degrees(170, 190), degrees(-180, 180), 360), (Turns{0, -1}));
  EXPECT_EQ(turns_into(degrees(10, 20), degrees(30, 40), 360), (Turns{}));
  EXPECT_EQ(turns_into(degrees(10, 20), degrees(-540, 540), 360), (Turns{0, -1, 1}));
  EXPECT_EQ(turns_into(degrees(0, 1), degrees(1e300, 1e301), 360).size(), 0U);
}

TEST(GlobeTurns, SourcesStayUnlessTheAntimeridianTearsThemApart) {
  const auto turns = [](const std::vector<Bounds>& boxes) { return gathered(boxes, 360, std::nullopt).turns; };
  EXPECT_EQ(turns({degrees(179, 180), degrees(-180, -179)}), (Turns{0, 1}));
  EXPECT_EQ(turns({degrees(-180, -179), degrees(179, 180), degrees(177, 178)}), (Turns{1, 0, 0}));
  EXPECT_EQ(turns({degrees(359, 360), degrees(0, 1)}), (Turns{-1, 0})) << "at zero likewise, for those who count from there";
  EXPECT_EQ(turns({degrees(-120, -100), degrees(100, 120)}), (Turns{0, 0})) << "160 degrees instead of 240 are not worth it";
  EXPECT_EQ(turns({degrees(-180, 0), degrees(0, 180)}), (Turns{0, 0}));
  EXPECT_EQ(turns({degrees(-180.00125, 180.00125)}), (Turns{0}));
  EXPECT_EQ(turns({degrees(10, 20), degrees(30, 40)}), (Turns{0, 0}));
  const Gathering fiji = gathered(std::vector{degrees(-180, -178), degrees(176, 180)}, 360, std::nullopt);
  EXPECT_EQ(fiji.bounds.west, 176.0);
  EXPECT_EQ(fiji.bounds.east, 182.0);
}

// Against the plain definition: over all places where the circle may be cut, the narrowest hull; and it is
// taken when it is less than half as wide as the boxes where they are.
TEST(GlobeTurns, TheNarrowestHullIsFound) {
  std::mt19937 random(3);
  int moved = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<Bounds> boxes;
    const int count = 1 + static_cast<int>(random() % 5);
    const double centre = random() % 2 != 0 ? 180.0 : static_cast<double>(random() % 360);
    for (int i = 0; i < count; ++i) {
      double west = centre - 40.0 + static_cast<double>(random() % 80);
      if (west >= 180.0) west -= 360.0;
      boxes.push_back(degrees(west, west + 1.0 + static_cast<double>(random() % 30)));
    }
    Bounds as_they_are;
    for (const Bounds& box : boxes) as_they_are.add(box);
    double narrowest = INFINITY;
    for (const Bounds& first : boxes) {
      double reach = 0.0;
      for (const Bounds& box : boxes) {
        const double offset = box.west - first.west - 360.0 * std::floor((box.west - first.west) / 360.0);
        reach = std::max(reach, offset + box.east - box.west);
      }
      narrowest = std::min(narrowest, reach);
    }
    const Gathering result = gathered(boxes, 360.0, std::nullopt);
    const double width = result.bounds.east - result.bounds.west;
    const double own = as_they_are.east - as_they_are.west;
    EXPECT_EQ(width, narrowest < own / 2 ? narrowest : own);
    moved += width < own ? 1 : 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Bounds lies = moved_by(boxes[i], result.turns[i] * 360.0);
      EXPECT_GE(lies.west, result.bounds.west);
      EXPECT_LE(lies.east, result.bounds.east);
    }
  }
  EXPECT_GT(moved, 500);
}

TEST(GlobeTurns, AreasAreRectanglesOnTheEarth) {
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  const geo::Crs utm = geo::Crs::from_epsg(32633).value();
  EXPECT_EQ(bounds_of({170, -10, -170, 10}, geographic)->east, 190.0);
  EXPECT_EQ(bounds_of({-180, -90, 180, 90}, geographic)->east, 180.0);
  EXPECT_EQ(bounds_of({0, 0, 1, 1}, utm)->east, 1.0);
  for (const Area& area : {Area{0, 0, 0, 1}, Area{0, 1, 1, 1}, Area{0, -91, 1, 1}, Area{0, 0, 1, 95}, Area{-541, 0, 1, 1},
                           Area{500000, 0, 500010, 5}, Area{0, NAN, 1, 1}, Area{NAN, 0, 1, 1}})
    EXPECT_EQ(bounds_of(area, geographic).error().code, ErrorCode::kUsage) << area_text(area);
  EXPECT_EQ(bounds_of({1, 0, 0, 1}, utm).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace vt::pipeline
