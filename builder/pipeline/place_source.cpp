#include "builder/pipeline/place_source.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// Where the source's first sample lies in texels of the grid, when its samples are as large as texels all over the source.
std::optional<Point2> offset_in_texels(const GridPlacement& grid, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const geo::GeoTransform& transform = source.transform;
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

// The whole number of texels by which nearest-neighbour resampling moves a source that misses the grid: the centre of texel i falls into
// sample i - offset rounded up from the half.
std::int64_t snapped(double offset) { return static_cast<std::int64_t>(std::ceil(offset - 0.5)); }

}  // namespace

Result<std::shared_ptr<const channels::ChannelCodec>> CodecShelf::codec_for(const channels::ChannelSettings& settings,
                                                                            const channels::SampleLayout& layout) {
  for (const auto& [known, codec] : codecs_)
    if (known == layout) return codec;
  VT_ASSIGN(std::shared_ptr<const channels::ChannelCodec> made, channels::make_codec(settings, layout));
  return codecs_.emplace_back(layout, std::move(made)).second;
}

Result<resample::PlacedSource> place_source(const ChosenSamples& samples, resample::Method resampling, const LayerInfo& layer,
                                            const geo::Crs& crs, const OpenSource& source, const Bounds& bounds) {
  const RasterInfo& info = source.raster->info();
  resample::PlacedSource placed;
  placed.raster = source.raster;
  placed.bands = samples.bands;
  placed.layout = samples.layout;

  const TexelRect whole{0, 0, layer.data.width, layer.data.height};
  if (source.transform.is_north_up() && crs.same_coordinates(source.crs)) {
    const auto offset = offset_in_texels(layer.grid, source);
    if (offset && (is_on_grid(*offset) || resampling == resample::Method::kNearest)) {
      placed.is_aligned = true;
      placed.offset_x = is_on_grid(*offset) ? std::llround(offset->x) : snapped(offset->x);
      placed.offset_y = is_on_grid(*offset) ? std::llround(offset->y) : snapped(offset->y);
      if (!is_on_grid(*offset))
        placed.moved = {static_cast<double>(placed.offset_x) - offset->x, static_cast<double>(placed.offset_y) - offset->y};
      placed.covered = intersect({placed.offset_x, placed.offset_y, info.width, info.height}, whole);
      return placed;
    }
  }
  placed.method = resampling;
  placed.warp = std::make_shared<const resample::GridWarp>(layer.grid, crs, source.transform, source.crs);
  const auto x0 = static_cast<std::int64_t>(std::floor((bounds.west - layer.grid.origin_x) / layer.grid.step_x)) - 1;
  const auto x1 = static_cast<std::int64_t>(std::ceil((bounds.east - layer.grid.origin_x) / layer.grid.step_x)) + 1;
  const auto y0 = static_cast<std::int64_t>(std::floor((layer.grid.origin_y - bounds.north) / layer.grid.step_y)) - 1;
  const auto y1 = static_cast<std::int64_t>(std::ceil((layer.grid.origin_y - bounds.south) / layer.grid.step_y)) + 1;
  placed.covered = intersect({x0, y0, x1 - x0, y1 - y0}, whole);
  return placed;
}

}  // namespace vt::pipeline
