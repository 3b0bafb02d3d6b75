#include "builder/resample/grid/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "tests/resample/polygon_area.h"

namespace vt::resample {
namespace {

// All samples that a coverage names, with what it says of each.
std::map<std::pair<std::int64_t, std::int64_t>, double> covered_by(const Quad& quad) {
  std::map<std::pair<std::int64_t, std::int64_t>, double> covered;
  const QuadCoverage coverage(quad);
  CoveredRun run;
  for (std::int64_t row = coverage.first_row(); row < coverage.end_row(); ++row) {
    coverage.row(row, run);
    for (std::size_t i = 0; i < run.covered.size(); ++i) covered[{run.first + static_cast<std::int64_t>(i), row}] = run.covered[i];
  }
  return covered;
}

void expect_defined(const Quad& quad) {
  const auto covered = covered_by(quad);
  const auto polygon = test::polygon_of(quad.corner);
  const auto low = [](double v) { return static_cast<std::int64_t>(std::floor(v)) - 1; };
  for (std::int64_t y = low(quad.least_y()); y <= low(quad.greatest_y()) + 2; ++y)
    for (std::int64_t x = low(quad.least_x()); x <= low(quad.greatest_x()) + 2; ++x) {
      const auto found = covered.find({x, y});
      // Differences of areas of up to the footprint's width, in double: 1e-16 of some hundred samples, and a
      // few operations.
      ASSERT_NEAR(found == covered.end() ? 0.0 : found->second, static_cast<double>(test::covered_area(polygon, x, y)), 1e-12)
          << x << "," << y << " of " << quad.corner[0].x << "," << quad.corner[0].y << " " << quad.corner[1].x << "," << quad.corner[1].y
          << " " << quad.corner[2].x << "," << quad.corner[2].y << " " << quad.corner[3].x << "," << quad.corner[3].y;
    }
}

Quad turned_square(const Point2& centre, double side, double angle, double aspect = 1.0) {
  const Point2 a{std::cos(angle) * side / 2, std::sin(angle) * side / 2};
  const Point2 b{-std::sin(angle) * side * aspect / 2, std::cos(angle) * side * aspect / 2};
  const auto at = [&](double u, double v) { return Point2{centre.x + u * a.x + v * b.x, centre.y + u * a.y + v * b.y}; };
  return {{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)}};
}

TEST(QuadCoverage, IsTheAreaOfThePolygonInEverySample) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-5.0, 5.0);
  std::uniform_real_distribution<double> angle(0.0, 6.3);
  std::uniform_real_distribution<double> side(0.05, 40.0);
  std::uniform_real_distribution<double> aspect(0.02, 1.0);
  std::uniform_real_distribution<double> bend(-0.1, 0.1);
  for (int i = 0; i < 400; ++i) {
    Quad quad = turned_square({place(random), place(random)}, side(random), i % 5 == 0 ? 0.0 : angle(random), aspect(random));
    if (i % 3 == 0)  // a little of its own at each corner, as a bent map gives it
      for (Point2& corner : quad.corner) corner = {corner.x + bend(random) / 5, corner.y + bend(random) / 5};
    if (i % 7 == 0) std::swap(quad.corner[1], quad.corner[3]);  // the other way round: a source that runs from south to north
    expect_defined(quad);
  }
  // Corners on the corners of samples, and edges along them.
  expect_defined({{Point2{2, 3}, Point2{6, 3}, Point2{6, 9}, Point2{2, 9}}});
  expect_defined({{Point2{0, 2}, Point2{2, 0}, Point2{4, 2}, Point2{2, 4}}});
  expect_defined({{Point2{0.25, 0.25}, Point2{0.75, 0.25}, Point2{0.75, 0.5}, Point2{0.25, 0.5}}});
}

// Quadrilaterals that share their corners leave nothing out and count nothing twice.
TEST(QuadCoverage, NeighboursCoverEverySampleOnce) {
  for (const double angle : {0.0, 0.03, 0.6, 0.785398, 2.0}) {
    for (const double side : {0.4, 1.3, 2.0, 7.7}) {
      const auto node = [&](int i, int j) {
        // Bent, so that no two are alike.
        const double u = i * side + 0.1 * side * std::sin(j);
        const double v = j * side + 0.1 * side * std::cos(2 * i);
        return Point2{u * std::cos(angle) - v * std::sin(angle), u * std::sin(angle) + v * std::cos(angle)};
      };
      std::map<std::pair<std::int64_t, std::int64_t>, double> sum;
      const int count = 14;
      for (int j = -count; j < count; ++j)
        for (int i = -count; i < count; ++i)
          for (const auto& [sample, covered] : covered_by({{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)}}))
            sum[sample] += covered;
      const auto reach = static_cast<std::int64_t>(count * side / 2);
      for (std::int64_t y = -reach; y < reach; ++y)
        for (std::int64_t x = -reach; x < reach; ++x)
          ASSERT_NEAR((sum[{x, y}]), 1.0, 1e-12) << angle << " " << side << " " << x << "," << y;
    }
  }
}

TEST(Quad, SidesShorterThanASampleBecomeOne) {
  const Quad quad = turned_square({3.0, 4.0}, 5.0, 0.3, 0.1).at_least_one_sample();
  const auto length = [](const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y); };
  EXPECT_NEAR(length(quad.corner[0], quad.corner[1]), 5.0, 1e-12);
  EXPECT_NEAR(length(quad.corner[1], quad.corner[2]), 1.0, 1e-12);
  EXPECT_NEAR((quad.corner[0].x + quad.corner[2].x) / 2, 3.0, 1e-12);
  EXPECT_NEAR((quad.corner[0].y + quad.corner[2].y) / 2, 4.0, 1e-12);
  // Without a rotation a shorter one is the unit square around its centre: bilinear interpolation.
  const Quad unit = turned_square({3.2, 4.7}, 0.3, 0.0).at_least_one_sample();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(unit.corner[i].x, one_sample_around({3.2, 4.7}).corner[i].x, 1e-12);
    EXPECT_NEAR(unit.corner[i].y, one_sample_around({3.2, 4.7}).corner[i].y, 1e-12);
  }
}

TEST(CoveredRun, IsTheLengthOfTheIntervalInEverySample) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  for (int i = 0; i < 200; ++i) {
    const double low = place(random);
    const double high = low + std::abs(place(random));
    const CoveredRun run = covered_run(low, high);
    double sum = 0.0;
    for (std::size_t c = 0; c < run.covered.size(); ++c) {
      const auto sample = static_cast<double>(run.first) + static_cast<double>(c);
      // Ends are moved onto sample edges that are as near as 1e-6.
      ASSERT_NEAR(run.covered[c], std::min(high, sample + 1) - std::max(low, sample), 2e-6);
      ASSERT_GT(run.covered[c], 0.0);
      sum += run.covered[c];
    }
    ASSERT_NEAR(sum, high - low, 2e-6);
  }
  const CoveredRun whole = covered_run(8.0000001, 15.9999999);
  EXPECT_EQ(whole.first, 8);
  EXPECT_EQ(whole.covered, std::vector<double>(8, 1.0));
}

}  // namespace
}  // namespace vt::resample
