#include "builder/pipeline/sources/stray_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "builder/pipeline/sources/plan_remarks.h"

namespace vt::pipeline {
namespace {

constexpr double kFar = 100.0;
constexpr double kOtherUnit = 1000.0;

// The lower one of an even number.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// What most sources are like.
struct Typical {
  Point2 centre;
  double size = 0.0;     // diagonal
  double scatter = 0.0;  // distance from the centre
  double step = 0.0;     // of a sample, as the geometric mean of both edges
};

struct Shape {
  Point2 centre;
  double size = 0.0;
  double step = 0.0;
};

Shape shape_of(const OpenSource& source, const Bounds& bounds) {
  const double width = bounds.east - bounds.west;
  const double height = bounds.north - bounds.south;
  const source::RasterInfo& info = source.raster->info();
  return {.centre = {(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2},
          .size = std::hypot(width, height),
          .step = std::sqrt(width / static_cast<double>(info.width) * height / static_cast<double>(info.height))};
}

double distance(Point2 a, Point2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

Typical typical_of(const std::vector<Shape>& shapes) {
  // Two files have no majority: the first is what the second is compared with.
  if (shapes.size() == 2) return {.centre = shapes[0].centre, .size = shapes[0].size, .scatter = 0.0, .step = shapes[0].step};
  const auto median_of = [&](const auto& number) {
    std::vector<double> values;
    values.reserve(shapes.size());
    for (const Shape& shape : shapes) values.push_back(number(shape));
    return median(std::move(values));
  };
  Typical typical;
  typical.centre = {median_of([](const Shape& s) { return s.centre.x; }), median_of([](const Shape& s) { return s.centre.y; })};
  typical.size = median_of([](const Shape& s) { return s.size; });
  typical.step = median_of([](const Shape& s) { return s.step; });
  typical.scatter = median_of([&](const Shape& s) { return distance(s.centre, typical.centre); });
  return typical;
}

}  // namespace

std::string Strays::as_reason() const {
  if (texts_.empty()) return {};
  const std::string more = texts_.size() > 1 ? fmt::format(" (and {} more files that do not fit)", texts_.size() - 1) : "";
  return "; the reason may be this file: " + texts_.front() + more;
}

void Strays::append_to(std::vector<std::string>& warnings) const {
  Remarks remarks("unlike the others");
  for (const std::string& text : texts_) remarks.add(text);
  remarks.append_to(warnings);
}

Strays find_strays(const geo::Crs& crs, const std::vector<OpenSource>& sources, const std::vector<Bounds>& bounds) {
  Strays strays;
  if (sources.size() < 2) return strays;
  std::vector<Shape> shapes;
  for (std::size_t i = 0; i < sources.size(); ++i) shapes.push_back(shape_of(sources[i], bounds[i]));
  const Typical typical = typical_of(shapes);
  const std::string others = sources.size() == 2 ? sources.front().request.path.string() + " lies" : "the others lie";
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const Shape& shape = shapes[i];
    const std::string path = sources[i].request.path.string();
    const double limit = kFar * std::max({typical.size, typical.scatter, shape.size});
    if (distance(shape.centre, typical.centre) > limit) {
      strays.add(fmt::format("{}: lies at {:.10g}, {:.10g}, but {} around {:.10g}, {:.10g} ({}); is its place or its CRS wrong? It says {}",
                             path, shape.centre.x, shape.centre.y, others, typical.centre.x, typical.centre.y, crs.text(),
                             sources[i].crs.text()));
    } else if (shape.step > 0.0 && typical.step > 0.0 &&
               (shape.step >= kOtherUnit * typical.step || typical.step >= kOtherUnit * shape.step)) {
      const bool is_large = shape.step > typical.step;
      const double ratio = is_large ? shape.step / typical.step : typical.step / shape.step;
      strays.add(fmt::format(
          "{}: its samples are {:.4g} times as {} as {}; is it in another unit? It says {}", path, ratio, is_large ? "large" : "small",
          sources.size() == 2 ? "those of " + sources.front().request.path.string() : "those of the others", sources[i].crs.text()));
    }
  }
  return strays;
}

}  // namespace vt::pipeline
