#include "builder/resample/grid/footprint.h"

#include <algorithm>
#include <cmath>

namespace vt::resample {
namespace {

// Without a call, which the baseline instruction set would need.
std::int64_t floor_of(double v) {
  const auto towards_zero = static_cast<std::int64_t>(v);
  return towards_zero - (static_cast<double>(towards_zero) > v ? 1 : 0);
}
std::int64_t ceil_of(double v) { return -floor_of(-v); }

}  // namespace

CoveredRun covered_run(double low, double high) {
  constexpr double kSnap = 1e-6;
  const auto snapped = [](double v) { return std::abs(v - std::round(v)) <= kSnap ? std::round(v) : v; };
  low = snapped(low);
  high = snapped(high);
  CoveredRun run{.first = floor_of(low), .covered = {}};
  for (std::int64_t i = run.first; i < ceil_of(high); ++i)
    run.covered.push_back(std::min(high, static_cast<double>(i + 1)) - std::max(low, static_cast<double>(i)));
  return run;
}

void clip(CoveredRun& run, std::int64_t first, std::int64_t end) {
  const auto count = [&] { return static_cast<std::int64_t>(run.covered.size()); };
  const std::int64_t before = std::clamp<std::int64_t>(first - run.first, 0, count());
  if (before > 0) run.covered.erase(run.covered.begin(), run.covered.begin() + before);
  run.first += before;
  run.covered.resize(static_cast<std::size_t>(std::clamp<std::int64_t>(end - run.first, 0, count())));
}

CoveredRun united(const CoveredRun& a, const CoveredRun& b) {
  if (a.covered.empty()) return b;
  if (b.covered.empty()) return a;
  CoveredRun run{.first = std::min(a.first, b.first), .covered = {}};
  run.covered.assign(static_cast<std::size_t>(std::max(a.end(), b.end()) - run.first), 0.0);
  for (const CoveredRun* one : {&a, &b})
    for (std::size_t i = 0; i < one->covered.size(); ++i) {
      double& covered = run.covered[static_cast<std::size_t>(one->first - run.first) + i];
      covered = std::max(covered, one->covered[i]);
    }
  return run;
}

CoveredRun surface_run(double centre, double width, std::int64_t first, std::int64_t end) {
  const double to_end = std::min(centre - static_cast<double>(first), static_cast<double>(end) - centre);
  width = std::max(1.0, std::min(width, 2 * to_end));
  const double whole = std::floor(width + 1e-6);
  const double rest = width - whole;
  CoveredRun run = covered_run(centre - whole / 2, centre + whole / 2);
  if (rest > 1e-6 && whole + 1 <= 2 * to_end) {
    CoveredRun wider = covered_run(centre - (whole + 1) / 2, centre + (whole + 1) / 2);
    for (double& covered : wider.covered) covered *= rest;
    for (std::size_t i = 0; i < run.covered.size(); ++i)
      wider.covered[static_cast<std::size_t>(run.first - wider.first) + i] += (1 - rest) * run.covered[i];
    run = std::move(wider);
  }
  clip(run, first, end);
  return run;
}

bool Quad::is_finite() const {
  return std::ranges::all_of(corner, [](const Point2& p) { return std::isfinite(p.x) && std::isfinite(p.y); });
}
double Quad::least_x() const { return std::min({corner[0].x, corner[1].x, corner[2].x, corner[3].x}); }
double Quad::greatest_x() const { return std::max({corner[0].x, corner[1].x, corner[2].x, corner[3].x}); }
double Quad::least_y() const { return std::min({corner[0].y, corner[1].y, corner[2].y, corner[3].y}); }
double Quad::greatest_y() const { return std::max({corner[0].y, corner[1].y, corner[2].y, corner[3].y}); }

namespace {

// Half of what leads from the middle of the side a-d to that of b-c.
Point2 half_across(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return {(b.x - a.x + c.x - d.x) / 4, (b.y - a.y + c.y - d.y) / 4};
}

}  // namespace

Quad Quad::at_least_one_sample() const {
  const Point2 across = half_across(corner[0], corner[1], corner[2], corner[3]);
  const Point2 down = half_across(corner[1], corner[2], corner[3], corner[0]);
  const auto lacks = [](const Point2& half) {
    const double square = 4 * (half.x * half.x + half.y * half.y);
    return square > 0.0 && square < 1.0 ? 1.0 / std::sqrt(square) - 1.0 : 0.0;
  };
  const double more_across = lacks(across);
  const double more_down = lacks(down);
  if (more_across == 0.0 && more_down == 0.0) return *this;
  Quad wider = *this;
  for (std::size_t i = 0; i < 4; ++i) {
    const double u = i == 1 || i == 2 ? more_across : -more_across;
    const double v = i >= 2 ? more_down : -more_down;
    wider.corner[i].x += u * across.x + v * down.x;
    wider.corner[i].y += u * across.y + v * down.y;
  }
  return wider;
}

Point2 Quad::widths() const {
  const Point2 across = half_across(corner[0], corner[1], corner[2], corner[3]);
  const Point2 down = half_across(corner[1], corner[2], corner[3], corner[0]);
  return {2 * std::hypot(across.x, down.x), 2 * std::hypot(across.y, down.y)};
}

Quad one_sample_around(const Point2& c) {
  return {{Point2{c.x - 0.5, c.y - 0.5}, Point2{c.x + 0.5, c.y - 0.5}, Point2{c.x + 0.5, c.y + 0.5}, Point2{c.x - 0.5, c.y + 0.5}}};
}

QuadCoverage::QuadCoverage(const Quad& quad) : first_row_(floor_of(quad.least_y())), end_row_(ceil_of(quad.greatest_y())) {
  double twice_area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point2& a = quad.corner[i];
    const Point2& b = quad.corner[(i + 1) % 4];
    twice_area += (a.x - quad.corner[0].x) * (b.y - quad.corner[0].y) - (b.x - quad.corner[0].x) * (a.y - quad.corner[0].y);
  }
  // With y to the south, a positive area runs down on its east side.
  const double turn = twice_area >= 0.0 ? 1.0 : -1.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point2& a = quad.corner[i];
    const Point2& b = quad.corner[(i + 1) % 4];
    if (a.y < b.y) edges_[static_cast<std::size_t>(edge_count_++)] = {a.x, a.y, b.x, b.y, (b.x - a.x) / (b.y - a.y), turn};
    if (a.y > b.y) edges_[static_cast<std::size_t>(edge_count_++)] = {b.x, b.y, a.x, a.y, (a.x - b.x) / (a.y - b.y), -turn};
  }
}

void QuadCoverage::row(std::int64_t row, CoveredRun& run) const {
  struct Part {
    double west;    // of what lies of the edge in this row
    double width;   // to its east end
    double height;  // with the edge's sign
  };
  const auto top = static_cast<double>(row);
  std::array<Part, 4> parts;
  std::size_t count = 0;
  double west = INFINITY;
  double east = -INFINITY;
  for (int e = 0; e < edge_count_; ++e) {
    const Edge& edge = edges_[static_cast<std::size_t>(e)];
    const double y0 = std::max(edge.y0, top);
    const double y1 = std::min(edge.y1, top + 1.0);
    if (!(y0 < y1)) continue;
    // Where the edge ends in this row its own end is taken, so that what the two edges of a corner make of it
    // is the same.
    const double xa = y0 == edge.y0 ? edge.x0 : edge.x0 + edge.slope * (y0 - edge.y0);
    const double xb = y1 == edge.y1 ? edge.x1 : edge.x0 + edge.slope * (y1 - edge.y0);
    const double low = std::min(xa, xb);
    const double high = std::max(xa, xb);
    west = std::min(west, low);
    east = std::max(east, high);
    parts[count++] = {low, high - low, edge.sign * (y1 - y0)};
  }
  run.covered.clear();
  if (count == 0) return;
  run.first = floor_of(west);
  run.covered.resize(static_cast<std::size_t>(ceil_of(east) - run.first), 0.0);
  double* const covered = run.covered.data();
  for (std::size_t i = 0; i < count; ++i) {
    const Part& part = parts[i];
    const double from = part.west - static_cast<double>(run.first);
    const double to = from + part.width;
    const auto first = static_cast<std::size_t>(from);
    for (std::size_t c = 0; c < first; ++c) covered[c] += part.height;
    if (to <= static_cast<double>(first + 1)) {  // in one column, on average in the middle
      if (first < run.covered.size()) covered[first] += part.height * (from + part.width / 2 - static_cast<double>(first));
      continue;
    }
    const double half_part = 0.5 / part.width;
    double before = static_cast<double>(first);
    for (std::size_t c = first; static_cast<double>(c) < to; ++c) {
      const auto x = static_cast<double>(c + 1);
      const double beyond = std::min(x, to) - from;
      const double area = from + beyond - beyond * beyond * half_part;
      covered[c] += part.height * (area - before);
      before = area;
    }
  }
  // Differences of equal areas are 0 but for rounding.
  for (double& one : run.covered) one = std::max(one, 0.0);
}

}  // namespace vt::resample
