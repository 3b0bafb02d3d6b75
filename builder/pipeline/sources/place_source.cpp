#include "builder/pipeline/sources/place_source.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/sources/globe_turns.h"
#include "builder/source/wrapped_raster.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// A raster and where it lies; a source itself, or the endless raster made of one.
struct Geometry {
  std::shared_ptr<const source::RasterSource> raster;
  geo::GeoTransform transform;
  geo::Crs crs;
  Bounds bounds;  // in the layer's CRS
};

// Where the raster's first sample lies in texels of the grid, when its samples are as large as texels all
// over it.
std::optional<Point2> offset_in_texels(const GridPlacement& grid, const RasterInfo& info, const geo::GeoTransform& transform) {
  const auto width = static_cast<double>(info.width);
  const auto height = static_cast<double>(info.height);
  const double column = (transform.x0 - grid.origin_x) / grid.step_x;
  const double row = (grid.origin_y - transform.y0) / grid.step_y;
  const double end_column = (transform.x0 + width * transform.x_column - grid.origin_x) / grid.step_x;
  const double end_row = (grid.origin_y - (transform.y0 + height * transform.y_row)) / grid.step_y;
  const auto is_near = [](double a, double b) { return std::abs(a - b) <= kGridTolerance; };
  if (!is_near(end_column, column + width) || !is_near(end_row, row + height)) return std::nullopt;
  return Point2{column, row};
}

bool is_on_grid(const Point2& offset) {
  return std::abs(offset.x - std::round(offset.x)) <= kGridTolerance && std::abs(offset.y - std::round(offset.y)) <= kGridTolerance;
}

// The whole number of texels by which nearest-neighbour resampling moves a source that misses the grid: the
// centre of texel i falls into sample i - offset rounded up from the half.
std::int64_t snapped(double offset) { return static_cast<std::int64_t>(std::ceil(offset - 0.5)); }

// Puts the raster on the layer's grid, `turns` times round the globe to the east of where it says it lies.
void lay(const Geometry& geometry, int turns, resample::Method resampling, const LayerGround& ground, resample::PlacedSource& placed) {
  const LayerInfo& layer = ground.layer;
  const geo::Crs& crs = ground.crs;
  const RasterInfo& info = geometry.raster->info();
  const TexelRect whole{0, 0, layer.data.width, layer.data.height};
  const double moved_x = turns * crs.turn().value_or(0.0);
  placed.raster = geometry.raster;
  if (geometry.transform.is_north_up() && crs.same_coordinates(geometry.crs)) {
    geo::GeoTransform transform = geometry.transform;
    transform.x0 += moved_x;
    const auto offset = offset_in_texels(layer.grid, info, transform);
    if (offset && (is_on_grid(*offset) || resampling == resample::Method::kNearest)) {
      placed.is_aligned = true;
      placed.offset_x = is_on_grid(*offset) ? std::llround(offset->x) : snapped(offset->x);
      placed.offset_y = is_on_grid(*offset) ? std::llround(offset->y) : snapped(offset->y);
      if (!is_on_grid(*offset))
        placed.moved = {static_cast<double>(placed.offset_x) - offset->x, static_cast<double>(placed.offset_y) - offset->y};
      placed.covered = intersect({placed.offset_x, placed.offset_y, info.width, info.height}, whole);
      return;
    }
  }
  placed.method = resampling;
  placed.warp = std::make_shared<const resample::GridWarp>(layer.grid, crs, geometry.transform, geometry.crs, turns);
  const Bounds bounds = moved_by(geometry.bounds, moved_x);
  const auto x0 = static_cast<std::int64_t>(std::floor((bounds.west - layer.grid.origin_x) / layer.grid.step_x)) - 1;
  const auto x1 = static_cast<std::int64_t>(std::ceil((bounds.east - layer.grid.origin_x) / layer.grid.step_x)) + 1;
  const auto y0 = static_cast<std::int64_t>(std::floor((layer.grid.origin_y - bounds.north) / layer.grid.step_y)) - 1;
  const auto y1 = static_cast<std::int64_t>(std::ceil((layer.grid.origin_y - bounds.south) / layer.grid.step_y)) + 1;
  placed.covered = intersect({x0, y0, x1 - x0, y1 - y0}, whole);
}

Bounds bounds_of_layer(const LayerInfo& layer) {
  return {.west = layer.grid.origin_x,
          .south = layer.grid.origin_y - static_cast<double>(layer.data.height) * layer.grid.step_y,
          .east = layer.grid.origin_x + static_cast<double>(layer.data.width) * layer.grid.step_x,
          .north = layer.grid.origin_y};
}

// The longitudes of the layer in degrees, those at its edges and between; all of a turn where its CRS has no
// answer.
Bounds longitudes_of(const Bounds& layer, const geo::Crs& crs) {
  constexpr int kSteps = 32;
  if (crs.kind() == geo::CrsKind::kPixel) return {};
  const auto near = crs.near_side();
  const double middle = (layer.west + layer.east) / 2 - crs.x_of_greenwich();
  const double centre_deg = crs.turn() ? 360.0 / *crs.turn() * middle : near ? near->central_deg : 0.0;
  Bounds degrees;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const Point2 place{layer.west + (layer.east - layer.west) * i / kSteps, layer.south + (layer.north - layer.south) * j / kSteps};
      const auto lonlat = crs.unwrapped_lonlat_from_crs(place);
      if (!lonlat) return {.west = centre_deg - 180.0, .south = -90.0, .east = centre_deg + 180.0, .north = 90.0};
      degrees.add(*lonlat);
    }
  return degrees;
}

// Columns after which a raster's samples come again: it goes round the globe once, or a little more.
std::optional<std::int64_t> columns_of_a_turn(const OpenSource& source) {
  constexpr double kTolerance = 0.01;  // samples by which steps that are written with few digits miss a turn
  const std::optional<double> turn = source.crs.turn();
  const geo::GeoTransform& t = source.transform;
  if (!turn || t.x_row != 0.0 || t.y_column != 0.0 || !(t.x_column > 0.0)) return std::nullopt;
  const double columns = *turn / t.x_column;
  const double whole = std::round(columns);
  if (whole < 1.0 || std::abs(columns - whole) > kTolerance || whole > static_cast<double>(source.raster->info().width))
    return std::nullopt;
  return static_cast<std::int64_t>(whole);
}

// The raster that goes on and on, as much of it as the layer's longitudes can see and half a turn more on
// both sides.
Geometry endless(const OpenSource& source, std::int64_t columns, const LayerGround& ground, const Bounds& bounds) {
  const double units_per_degree = *source.crs.turn() / 360.0;
  const auto column_of = [&](double longitude_deg) {
    const double x = source.crs.x_of_greenwich() + longitude_deg * units_per_degree;
    return static_cast<std::int64_t>(std::floor((x - source.transform.x0) / source.transform.x_column));
  };
  const std::int64_t first = column_of(ground.longitudes_deg.west) - columns / 2 - 1;
  const std::int64_t last = column_of(ground.longitudes_deg.east) + columns / 2 + 1;
  Geometry geometry{.raster = std::make_shared<const source::WrappedRaster>(source.raster, columns, first, last - first + 1),
                    .transform = source.transform,
                    .crs = source.crs,
                    .bounds = bounds};
  geometry.transform.x0 += static_cast<double>(first) * source.transform.x_column;
  if (ground.crs.turn()) {
    geometry.bounds.west = ground.bounds.west;
    geometry.bounds.east = ground.bounds.east;
  }
  return geometry;
}

// Whether texels of the layer lie so near the raster's eastern and western edge that samples on both sides of
// it matter to them.
bool sees_the_seam(const OpenSource& source, const LayerGround& ground) {
  constexpr double kReach = 64.0;  // samples or texels, whichever are larger: more than any footprint reaches
  const double degrees_per_unit = 360.0 / *source.crs.turn();
  const double texel_deg = (ground.longitudes_deg.east - ground.longitudes_deg.west) / static_cast<double>(ground.layer.data.width);
  const double seam_deg = (source.transform.x0 - source.crs.x_of_greenwich()) * degrees_per_unit;
  const double reach_deg = kReach * std::max(source.transform.x_column * degrees_per_unit, texel_deg);
  const Bounds near_seam{.west = seam_deg - reach_deg, .south = -90.0, .east = seam_deg + reach_deg, .north = 90.0};
  return !turns_into(near_seam, ground.longitudes_deg, 360.0).empty();
}

}  // namespace

Result<std::shared_ptr<const channels::ChannelCodec>> CodecShelf::codec_for(const channels::ChannelSettings& settings,
                                                                            const channels::SampleLayout& layout) {
  for (const auto& [known, codec] : codecs_)
    if (known == layout) return codec;
  VT_ASSIGN(std::shared_ptr<const channels::ChannelCodec> made, channels::make_codec(settings, layout));
  return codecs_.emplace_back(layout, std::move(made)).second;
}

namespace {

// By how many turns the source is moved to lie in the layer, its own place first.
std::vector<int> turns_of(const LayerGround& ground, const OpenSource& source, const Bounds& bounds) {
  if (ground.crs.turn()) return turns_into(bounds, ground.bounds, *ground.crs.turn());
  if (!source.crs.turn()) return {0};
  // A layer without turns has its longitudes about its central meridian.
  const double degrees_per_unit = 360.0 / *source.crs.turn();
  Bounds degrees;
  for (const double column : {0.0, static_cast<double>(source.raster->info().width)})
    for (const double row : {0.0, static_cast<double>(source.raster->info().height)})
      degrees.add(Point2{(source.transform.crs_from_raster({column, row}).x - source.crs.x_of_greenwich()) * degrees_per_unit, 0.0});
  return turns_into(degrees, ground.longitudes_deg, 360.0);
}

}  // namespace

LayerGround::LayerGround(const LayerInfo& layer_info, const geo::Crs& layer_crs)
    : layer(layer_info), crs(layer_crs), bounds(bounds_of_layer(layer_info)), longitudes_deg(longitudes_of(bounds, layer_crs)) {}

SourcePlaces place_source(const ChosenSamples& samples, resample::Method resampling, const LayerGround& ground, const OpenSource& source,
                          const Bounds& bounds) {
  resample::PlacedSource unplaced;
  unplaced.bands = samples.bands;
  unplaced.layout = samples.layout;
  const Geometry itself{.raster = source.raster, .transform = source.transform, .crs = source.crs, .bounds = bounds};
  SourcePlaces places;
  for (const int turns : turns_of(ground, source, bounds)) {
    resample::PlacedSource placed = unplaced;
    lay(itself, turns, resampling, ground, placed);
    if (placed.covered.empty()) continue;
    // In a layer of more than one turn a source can only repeat itself where it is already: its own place
    // counts.
    const bool adds = std::ranges::none_of(places.placed, [&](const resample::PlacedSource& there) {
      return ground.crs.turn() && intersect(there.covered, placed.covered) == placed.covered;
    });
    if (!adds) continue;
    places.placed.push_back(std::move(placed));
    places.turns.push_back(turns);
  }
  if (places.placed.empty()) {  // outside
    places.placed.push_back(unplaced);
    lay(itself, 0, resampling, ground, places.placed.front());
    places.placed.front().covered = {};
    places.turns = {0};
    return places;
  }
  const auto columns = columns_of_a_turn(source);
  const bool is_whole_and_aligned = places.placed.size() == 1 && places.placed.front().is_aligned;
  if (columns && !is_whole_and_aligned && sees_the_seam(source, ground)) {
    places = {.placed = {unplaced}, .turns = {0}, .comes_again = *columns};
    lay(endless(source, *columns, ground, bounds), 0, resampling, ground, places.placed.front());
  }
  return places;
}

bool reaches_into(const Bounds& area, const geo::Crs& crs, const OpenSource& source) {
  constexpr int kSteps = 32;
  const RasterInfo& info = source.raster->info();
  const auto raster_from_crs = source.transform.inverse();
  const double turn = source.crs.turn().value_or(0.0);
  for (int i = 0; raster_from_crs && i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const auto place =
          convert(source.crs, crs, {area.west + (area.east - area.west) * i / kSteps, area.south + (area.north - area.south) * j / kSteps});
      if (!place) continue;
      for (const int turns : {0, -1, 1}) {
        const Point2 raster = raster_from_crs->apply({place->x + turns * turn, place->y});
        if (raster.x >= 0.0 && raster.y >= 0.0 && raster.x <= static_cast<double>(info.width) &&
            raster.y <= static_cast<double>(info.height))
          return true;
      }
    }
  return false;
}

}  // namespace vt::pipeline
