#include "builder/pipeline/sources/globe_turns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numeric>

namespace vt::pipeline {
namespace {

// A turn is no whole number of any unit in floating point; edges that are meant to meet miss each other by
// less than this part of it.
constexpr double kRounding = 1e-12;

constexpr double kMostTurns = 8.0;      // between what lies within 540 degrees and a store's area that does not
constexpr double kFarthestDeg = 540.0;  // a turn and a half to either side

bool is_apart(const Bounds& a, const Bounds& b) { return !(a.west < b.east && b.west < a.east); }

// The longest gap between the boxes on the circle.
struct Gap {
  double end = 0.0;  // where a box begins again
  double length = 0.0;
};
Gap longest_gap(std::span<const Bounds> boxes, double turn) {
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto start = [&](std::size_t i) { return boxes[i].west - turn * std::floor(boxes[i].west / turn); };
  std::ranges::sort(order, {}, start);
  const auto end = [&](std::size_t i) { return start(i) + boxes[i].east - boxes[i].west; };
  double reach = start(order.front());
  for (const std::size_t i : order) reach = std::max(reach, end(i) - turn);  // those that go over the end come in at the start
  Gap longest;
  for (const std::size_t i : order) {
    if (start(i) - reach > longest.length) longest = {.end = start(i), .length = start(i) - reach};
    reach = std::max(reach, end(i));
  }
  const double over_the_end = start(order.front()) + turn - reach;
  if (over_the_end > longest.length) longest = {.end = start(order.front()), .length = over_the_end};
  return longest;
}

std::vector<int> gathering_turns(std::span<const Bounds> boxes, const Bounds& all, double turn) {
  std::vector<int> turns(boxes.size(), 0);
  const Gap gap = longest_gap(boxes, turn);
  if (!(turn - gap.length < (all.east - all.west) / 2)) return turns;
  // From the place where the gap ends, counted from half a turn before zero: 170 to 190 degrees, not -190 to
  // -170.
  const double west = gap.end - turn * std::floor(gap.end / turn + 0.5);
  for (std::size_t i = 0; i < boxes.size(); ++i) turns[i] = -static_cast<int>(std::floor((boxes[i].west - west) / turn + kRounding));
  return turns;
}

}  // namespace

std::string area_text(const Area& area) {
  return "west " + std::to_string(area.west) + " south " + std::to_string(area.south) + " east " + std::to_string(area.east) + " north " +
         std::to_string(area.north);
}

Result<Bounds> bounds_of(const Area& area, const geo::Crs& crs) {
  Bounds bounds{area.west, area.south, area.east, area.north};
  const std::optional<double> turn = crs.turn();
  if (turn && bounds.west > bounds.east) bounds.east += *turn;
  if (!(bounds.west < bounds.east) || !(bounds.south < bounds.north))
    return fail(ErrorCode::kUsage, "an area has west < east and south < north" +
                                       std::string(turn ? ", or west > east across the antimeridian" : "") + ", found " + area_text(area));
  if (crs.kind() == geo::CrsKind::kGeographic &&
      !(bounds.south >= -90.0 && bounds.north <= 90.0 && bounds.west >= -kFarthestDeg && bounds.east <= kFarthestDeg))
    return fail(ErrorCode::kUsage, "an area in " + crs.text() +
                                       " is in degrees, latitudes from -90 to 90 and longitudes from -540 to 540, " + "found " +
                                       area_text(area));
  return bounds;
}

Result<Area> normalised(const Area& area, const geo::Crs& crs) {
  VT_ASSIGN(const Bounds bounds, bounds_of(area, crs));
  return Area{bounds.west, bounds.south, bounds.east, bounds.north};
}

Bounds moved_by(const Bounds& box, double x) { return {box.west + x, box.south, box.east + x, box.north}; }

std::vector<int> turns_into(const Bounds& box, const Bounds& area, double turn) {
  const double first = std::ceil((area.west - box.east) / turn + kRounding);
  const double last = std::floor((area.east - box.west) / turn - kRounding);
  if (!(first <= kMostTurns) || !(last >= -kMostTurns)) return {};
  std::vector<int> turns;
  for (auto n = static_cast<int>(std::max(first, -kMostTurns)); n <= std::min(last, kMostTurns); ++n) turns.push_back(n);
  std::ranges::stable_sort(turns, {}, [](int n) { return std::abs(n); });
  return turns;
}

Gathering gathered(std::span<const Bounds> boxes, double turn, const std::optional<Bounds>& store_area) {
  Bounds as_they_are;
  for (const Bounds& box : boxes) as_they_are.add(box);
  Gathering result{.turns = gathering_turns(boxes, as_they_are, turn), .bounds = {}};
  const auto lies = [&](std::size_t i) { return moved_by(boxes[i], result.turns[i] * turn); };
  for (std::size_t i = 0; i < boxes.size(); ++i) result.bounds.add(lies(i));
  if (!store_area) return result;

  if (is_apart(result.bounds, *store_area)) {
    const std::vector<int> inward = turns_into(result.bounds, *store_area, turn);
    if (inward.empty()) return result;
    for (int& turns : result.turns) turns += inward.front();
    result.bounds = moved_by(result.bounds, inward.front() * turn);
  }
  double west = INFINITY;
  double east = -INFINITY;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (const int n : turns_into(lies(i), *store_area, turn)) {
      const Bounds copy = moved_by(lies(i), n * turn);
      west = std::min(west, std::max(copy.west, store_area->west));
      east = std::max(east, std::min(copy.east, store_area->east));
    }
  }
  const double rounding = kRounding * turn;
  const bool comes_in_again = west < result.bounds.west - rounding || east > result.bounds.east + rounding;
  if (comes_in_again) {
    result.bounds.west = west;
    result.bounds.east = east;
  }
  return result;
}

}  // namespace vt::pipeline
