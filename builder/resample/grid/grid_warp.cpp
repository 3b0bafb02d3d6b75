#include "builder/resample/grid/grid_warp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace vt::resample {
namespace {

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

Point2 difference(const Point2& a, const Point2& b) { return {a.x - b.x, a.y - b.y}; }
Point2 scaled(const Point2& p, double factor) { return {p.x * factor, p.y * factor}; }

// Weights of three nodes at 0, 1/2 and 1: the quadratic through them. Exactly 1 at its own node.
std::array<double, 3> weights_at(double t) { return {(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)}; }

double mix(const std::array<double, 3>& w, double a, double b, double c) { return w[0] * a + w[1] * b + w[2] * c; }

// The greatest singular value of a 2 x 2 matrix, given by its columns; 0 when one of them is no number.
double greatest_stretch(const Point2& a, const Point2& b) {
  const double aa = a.x * a.x + a.y * a.y;
  const double bb = b.x * b.x + b.y * b.y;
  const double ab = a.x * b.x + a.y * b.y;
  const double square = (aa + bb + std::hypot(aa - bb, 2 * ab)) / 2;
  return std::isfinite(square) ? std::sqrt(square) : 0.0;
}

// Samples per texel in the four quarters of a cell of 3 x 3 nodes.
struct Stretch {
  double least = 0.0;  // of those that have one: where a cell lies across the line at which longitudes jump, it is the one that is true
  double most = 0.0;
};

Stretch stretch_of(const std::array<Point2, 9>& node, double width, double height) {
  Stretch stretch{.least = std::numeric_limits<double>::infinity()};
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t column = 0; column < 2; ++column) {
      double here = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t along = 3 * (row + i / 2) + column;  // the quarter's upper or lower edge
        const std::size_t down = 3 * row + column + i % 2;     // its left or right edge
        here = std::max(here, greatest_stretch(scaled(difference(node[along + 1], node[along]), 2 / width),
                                               scaled(difference(node[down + 3], node[down]), 2 / height)));
      }
      if (here == 0.0) continue;
      stretch.least = std::min(stretch.least, here);
      stretch.most = std::max(stretch.most, here);
    }
  if (stretch.most == 0.0) stretch.least = 0.0;
  return stretch;
}

}  // namespace

GridWarp::GridWarp(const GridPlacement& grid, geo::Crs grid_crs, const geo::GeoTransform& source, geo::Crs source_crs, int turns)
    : grid_(grid),
      grid_crs_(std::move(grid_crs)),
      source_(source),
      source_crs_(std::move(source_crs)),
      same_crs_(grid_crs_.same_coordinates(source_crs_)),
      turns_(turns),
      moved_(turns * (same_crs_ ? grid_crs_.turn().value_or(0.0) : 360.0)) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  raster_from_source_crs_ = source.inverse().value_or(geo::GeoTransform{nan, nan, nan, nan, nan, nan});
  if (same_crs_) {
    const geo::GeoTransform& t = raster_from_source_crs_;
    affine_stretch_ =
        greatest_stretch({t.x_column * grid.step_x, t.y_column * grid.step_x}, {t.x_row * grid.step_y, t.y_row * grid.step_y});
  }
  // JSON writes the shortest decimal that reads back as the same double.
  nlohmann::json facts = {
      {"grid", {grid.origin_x, grid.origin_y, grid.step_x, grid.step_y}},
      {"grid_crs", grid_crs_.to_json()},
      {"transform", {source.x0, source.x_column, source.x_row, source.y0, source.y_column, source.y_row}},
      {"source_crs", source_crs_.to_json()},
  };
  if (turns != 0) facts["turns"] = turns;
  facts_ = facts.dump();
}

Point2 GridWarp::exact(Point2 texel) const {
  Point2 crs{grid_.origin_x + texel.x * grid_.step_x, grid_.origin_y - texel.y * grid_.step_y};
  if (!same_crs_) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto lonlat = grid_crs_.unwrapped_lonlat_from_crs(crs);
    if (!lonlat) return {nan, nan};
    const auto source = source_crs_.crs_from_lonlat({lonlat->x - moved_, lonlat->y});
    if (!source) return {nan, nan};
    crs = *source;
  } else {
    crs.x -= moved_;
  }
  return raster_from_source_crs_.apply(crs);
}

void GridWarp::map_centres(const TexelRect& rect, std::span<Point2> out, std::vector<Patch>* patches) const {
  if (patches != nullptr) patches->clear();
  map({rect, 0.5, out}, patches);
}

void GridWarp::map_corners(const TexelRect& rect, std::span<Point2> out) const {
  map({{rect.x, rect.y, rect.width + 1, rect.height + 1}, 0.0, out}, nullptr);
}

void GridWarp::map(const Points& points, std::vector<Patch>* patches) const {
  const TexelRect& rect = points.rect;
  if (same_crs_) {  // one affine map: nothing to approximate
    std::size_t next = 0;
    for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
      for (std::int64_t x = rect.x; x < rect.right(); ++x)
        points.out[next++] = exact({static_cast<double>(x) + points.offset, static_cast<double>(y) + points.offset});
    if (patches != nullptr) patches->push_back({rect, affine_stretch_});
    return;
  }
  for (std::int64_t y = floor_div(rect.y, kCellHeight) * kCellHeight; y < rect.bottom(); y += kCellHeight)
    for (std::int64_t x = floor_div(rect.x, kCellWidth) * kCellWidth; x < rect.right(); x += kCellWidth)
      map_cell({x, y, kCellWidth, kCellHeight}, points, patches);
}

GridWarp::Cell GridWarp::cell_at(const TexelRect& texels) const {
  Cell cell{texels, {}};
  for (std::size_t i = 0; i < 9; ++i)
    cell.node[i] = exact({static_cast<double>(texels.x) + static_cast<double>(texels.width) * static_cast<double>(i % 3) / 2,
                          static_cast<double>(texels.y) + static_cast<double>(texels.height) * static_cast<double>(i / 3) / 2});
  return cell;
}

// The leading errors are those of the third derivatives along either axis, each of them greatest near a
// quarter of the cell, odd about its middle. Of places a quarter from two edges one has both with the same
// sign. NaN compares false: such a cell is cut.
bool GridWarp::is_believed(const Cell& cell, double tolerance) const {
  for (const double v : {0.25, 0.75})
    for (const double u : {0.25, 0.75}) {
      const Point2 is = exact({static_cast<double>(cell.texels.x) + u * static_cast<double>(cell.texels.width),
                               static_cast<double>(cell.texels.y) + v * static_cast<double>(cell.texels.height)});
      const auto across = weights_at(u);
      const auto down = weights_at(v);
      Point2 guess;
      for (std::size_t row = 0; row < 3; ++row) {
        const Point2* n = &cell.node[3 * row];
        guess.x += down[row] * mix(across, n[0].x, n[1].x, n[2].x);
        guess.y += down[row] * mix(across, n[0].y, n[1].y, n[2].y);
      }
      if (!(std::abs(guess.x - is.x) <= tolerance && std::abs(guess.y - is.y) <= tolerance)) return false;
    }
  return true;
}

void GridWarp::map_cell(const TexelRect& texels, const Points& points, std::vector<Patch>* patches) const {
  const TexelRect part = intersect(texels, points.rect);
  if (part.empty()) return;
  const Cell cell = cell_at(texels);
  const Stretch stretch = stretch_of(cell.node, static_cast<double>(texels.width), static_cast<double>(texels.height));
  const bool is_smooth = is_believed(cell, kTolerance * std::max(1.0, stretch.least));
  if (!is_smooth && texels.height > kLeastCell) {
    const std::int64_t w = texels.width / 2;
    const std::int64_t h = texels.height / 2;
    for (const std::int64_t y : {texels.y, texels.y + h})
      for (const std::int64_t x : {texels.x, texels.x + w}) map_cell({x, y, w, h}, points, patches);
    return;
  }
  if (patches != nullptr) patches->push_back({part, is_smooth ? stretch.most : stretch.least});
  for (std::int64_t y = part.y; y < part.bottom(); ++y) {
    Point2* out = &points.out[static_cast<std::size_t>((y - points.rect.y) * points.rect.width + (part.x - points.rect.x))];
    if (!is_smooth) {
      for (std::int64_t x = part.x; x < part.right(); ++x)
        *out++ = exact({static_cast<double>(x) + points.offset, static_cast<double>(y) + points.offset});
      continue;
    }
    // The quadratic of this row: c0 + t (c1 + t c2), t from 0 to 1 along the cell.
    const auto w = weights_at((static_cast<double>(y - texels.y) + points.offset) / static_cast<double>(texels.height));
    const auto& n = cell.node;
    const std::array<Point2, 3> at{Point2{mix(w, n[0].x, n[3].x, n[6].x), mix(w, n[0].y, n[3].y, n[6].y)},
                                   Point2{mix(w, n[1].x, n[4].x, n[7].x), mix(w, n[1].y, n[4].y, n[7].y)},
                                   Point2{mix(w, n[2].x, n[5].x, n[8].x), mix(w, n[2].y, n[5].y, n[8].y)}};
    const Point2 c1{4 * at[1].x - 3 * at[0].x - at[2].x, 4 * at[1].y - 3 * at[0].y - at[2].y};
    const Point2 c2{2 * (at[0].x + at[2].x) - 4 * at[1].x, 2 * (at[0].y + at[2].y) - 4 * at[1].y};
    const double step = 1.0 / static_cast<double>(texels.width);
    const double first = (static_cast<double>(part.x - texels.x) + points.offset) * step;
    for (std::int64_t i = 0; i < part.width; ++i) {
      const double t = first + static_cast<double>(i) * step;
      out[i] = {at[0].x + t * (c1.x + t * c2.x), at[0].y + t * (c1.y + t * c2.y)};
    }
  }
}

double GridWarp::most_samples_per_texel(const TexelRect& rect) const {
  if (same_crs_ || rect.empty()) return affine_stretch_;
  constexpr int kPlaces = 5;  // along each axis, the edges among them
  double most = 0.0;
  for (int row = 0; row < kPlaces; ++row)
    for (int column = 0; column < kPlaces; ++column) {
      const double x = static_cast<double>(rect.x) + static_cast<double>(rect.width) * column / (kPlaces - 1);
      const double y = static_cast<double>(rect.y) + static_cast<double>(rect.height) * row / (kPlaces - 1);
      // The shorter of the steps to both sides: the other one may lead over the line at which longitudes
      // jump.
      const Point2 here = exact({x, y});
      const auto step = [&](double dx, double dy) {
        return greatest_stretch(difference(exact({x + dx, y}), here), difference(exact({x, y + dy}), here));
      };
      const double ahead = step(1.0, 1.0);
      const double behind = step(-1.0, -1.0);
      most = std::max(most, ahead == 0.0 || behind == 0.0 ? std::max(ahead, behind) : std::min(ahead, behind));
    }
  return most;
}

std::optional<GridWarp::SampleOffset> GridWarp::offset_of(const GridWarp& other, std::int64_t other_width,
                                                          std::int64_t other_height) const {
  if (!source_crs_.same_coordinates(other.source_crs_)) return std::nullopt;
  const std::optional<double> turn = source_crs_.turn();
  if (turns_ != other.turns_ && !turn) return std::nullopt;
  const double moved = turn.value_or(0.0) * (other.turns_ - turns_);
  const auto width = static_cast<double>(other_width);
  const auto height = static_cast<double>(other_height);
  const auto place = [&](double x, double y) {
    const Point2 crs = other.source_.crs_from_raster({x, y});
    return raster_from_source_crs_.apply({crs.x + moved, crs.y});
  };
  const Point2 first = place(0.0, 0.0);
  const Point2 offset{std::round(first.x), std::round(first.y)};
  for (const Point2& corner : {Point2{0.0, 0.0}, Point2{width, 0.0}, Point2{0.0, height}, Point2{width, height}}) {
    const Point2 is = place(corner.x, corner.y);
    if (!(std::abs(is.x - offset.x - corner.x) <= kSameGrid && std::abs(is.y - offset.y - corner.y) <= kSameGrid)) return std::nullopt;
  }
  constexpr double kFarthest = 0x1p40;  // beyond it two rasters of one grid are no neighbours
  if (!(std::abs(offset.x) <= kFarthest && std::abs(offset.y) <= kFarthest)) return std::nullopt;
  return SampleOffset{static_cast<std::int64_t>(offset.x), static_cast<std::int64_t>(offset.y)};
}

}  // namespace vt::resample
