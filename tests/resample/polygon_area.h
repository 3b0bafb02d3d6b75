// The definition of what a polygon covers of a sample: cut it by the sample's four edges, take the area of
// what is left (Sutherland & Hodgman 1974, and the shoelace formula), all in long double.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "store/vt_mapping.h"

namespace vt::test {

struct LongPoint {
  long double x, y;
};

// Keeps what lies on the side of `edge` where a * x + b * y <= c.
inline std::vector<LongPoint> cut(const std::vector<LongPoint>& polygon, long double a, long double b, long double c) {
  std::vector<LongPoint> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const LongPoint& p = polygon[i];
    const LongPoint& q = polygon[(i + 1) % polygon.size()];
    const long double dp = a * p.x + b * p.y - c;
    const long double dq = a * q.x + b * q.y - c;
    if (dp <= 0) kept.push_back(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      const long double t = dp / (dp - dq);
      kept.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return kept;
}

inline long double area_of(const std::vector<LongPoint>& polygon) {
  long double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const LongPoint& p = polygon[i];
    const LongPoint& q = polygon[(i + 1) % polygon.size()];
    twice += p.x * q.y - q.x * p.y;
  }
  return (twice < 0 ? -twice : twice) / 2;
}

inline std::vector<LongPoint> polygon_of(const std::array<Point2, 4>& corners) {
  std::vector<LongPoint> polygon;
  for (const Point2& p : corners) polygon.push_back({p.x, p.y});
  return polygon;
}

// The area of the sample in column `x`, row `y`.
inline long double covered_area(std::vector<LongPoint> polygon, std::int64_t x, std::int64_t y) {
  polygon = cut(polygon, -1, 0, -static_cast<long double>(x));
  polygon = cut(polygon, 1, 0, static_cast<long double>(x + 1));
  polygon = cut(polygon, 0, -1, -static_cast<long double>(y));
  polygon = cut(polygon, 0, 1, static_cast<long double>(y + 1));
  return area_of(polygon);
}

}  // namespace vt::test
