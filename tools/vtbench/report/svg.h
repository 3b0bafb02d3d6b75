// Charts as SVG text, readable on a light page without any script or style sheet. Knows nothing of what is
// charted.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace vt::bench {

// Horizontal bars in groups; all start at 0 on one axis.
struct Bar {
  std::string label;
  double value = 0.0;
  double low = 0.0;  // of the runs: a thin line from low to high
  double high = 0.0;
  bool is_ours = false;
};
struct BarGroup {
  std::string title;
  std::vector<Bar> bars;
};
struct BarChart {
  std::string title;
  std::string axis;                // with the unit
  std::vector<std::string> notes;  // small print: machine, input
  std::vector<BarGroup> groups;
};
[[nodiscard]] std::string svg_of(const BarChart& chart);

// Points in a plane, those of one series joined in order or standing alone; x may be logarithmic, values are
// then above 0.
struct Point {
  double x = 0.0;
  double y = 0.0;
  std::string label;
};
struct Series {
  std::string name;
  std::vector<Point> points;
  bool is_joined = true;
};
struct ReferenceLine {
  double y = 0.0;
  std::string label;
};
struct ScatterChart {
  std::string title;
  std::string x_axis;
  std::string y_axis;
  bool log_x = false;
  std::vector<std::string> notes;
  std::vector<Series> series;
  std::optional<ReferenceLine> line;
};
[[nodiscard]] std::string svg_of(const ScatterChart& chart);

// Round numbers (1, 2 or 5 times a power of ten apart), about `count` of them, the first at or below `low`,
// the last at or above `high`.
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int count);

}  // namespace vt::bench
