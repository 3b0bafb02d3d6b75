// What lies under a texel: which samples of a source, and how much of each. A sample is the unit square of
// its column and row; footprints are measured in samples. Private to this folder. Pure geometry in double,
// any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "store/vt_mapping.h"

namespace vt::resample {

// A part of a sample below this does not make the sample's value one of the least or greatest: the edges of
// grids that are the same by design meet to about as much (GridWarp::kSameGrid).
inline constexpr double kLeastTouch = 1e-4;

// Samples of one row or column and how much of each, 0 to 1.
struct CoveredRun {
  std::int64_t first = 0;
  std::vector<double> covered;

  [[nodiscard]] std::int64_t end() const { return first + static_cast<std::int64_t>(covered.size()); }
  [[nodiscard]] double of(std::int64_t sample) const {
    return sample >= first && sample < end() ? covered[static_cast<std::size_t>(sample - first)] : 0.0;
  }
};

// Takes away what lies outside `first` to `end`.
void clip(CoveredRun& run, std::int64_t first, std::int64_t end);

// What the interval from `low` to `high` covers. Ends within 1e-6 of a sample's edge are that edge.
[[nodiscard]] CoveredRun covered_run(double low, double high);

// The larger covered part of each sample that lies in either run.
[[nodiscard]] CoveredRun united(const CoveredRun& a, const CoveredRun& b);

// The weights with which a value of a surface at `centre` is made of samples between `first` and `end`, along
// one axis: over `width` samples, at least one. They are those of an interval of n samples and one of n + 1,
// n the whole part of the width, mixed so that their sum is the width. An interval of a whole number of
// samples holds every part of a sample equally often wherever it lies, so a ramp stays a ramp at any width;
// one sample is linear interpolation; a whole number is the mean of so many samples. Near an end the interval
// is narrowed, so that it stays symmetric about its centre; what still sticks out (of one sample) is cut off,
// which repeats the last sample.
[[nodiscard]] CoveredRun surface_run(double centre, double width, std::int64_t first, std::int64_t end);

// A quadrilateral; neighbours among its corners follow each other.
struct Quad {
  std::array<Point2, 4> corner;

  [[nodiscard]] bool is_finite() const;
  [[nodiscard]] double least_x() const;
  [[nodiscard]] double greatest_x() const;
  [[nodiscard]] double least_y() const;
  [[nodiscard]] double greatest_y() const;
  // Stretched about its centre along its own sides, where these are shorter than one sample.
  [[nodiscard]] Quad at_least_one_sample() const;
  // The intervals along columns and rows that spread as it does: of equal variance.
  [[nodiscard]] Point2 widths() const;
};

// The unit square around `centre`, whose sides run along the samples'.
[[nodiscard]] Quad one_sample_around(const Point2& centre);

// Exactly how much of each sample a convex quadrilateral covers, row by row: the sum over its edges, east
// ones less west ones, of the area of the sample that lies west of the edge, within the heights at which the
// edge is. Of an edge x(y) from x0 to x1 over a height h the area west of it and of x is a quadratic in x.
class QuadCoverage {
 public:
  explicit QuadCoverage(const Quad& quad);

  [[nodiscard]] std::int64_t first_row() const { return first_row_; }
  [[nodiscard]] std::int64_t end_row() const { return end_row_; }
  // The covered samples of a row into `run`.
  void row(std::int64_t row, CoveredRun& run) const;

 private:
  struct Edge {
    double x0, y0, x1, y1;  // y0 < y1
    double slope;           // of x over y
    double sign;            // 1 on the east side, -1 on the west side
  };

  std::array<Edge, 4> edges_{};
  int edge_count_ = 0;
  std::int64_t first_row_ = 0;
  std::int64_t end_row_ = 0;
};

}  // namespace vt::resample
