#include "builder/pipeline/sources/sure_cover.h"

#include <cmath>
#include <vector>

#include "builder/resample/grid/rect_index.h"

namespace vt::pipeline {
namespace {

bool may_lack_data(const channels::SampleLayout& layout) {
  const bool may_be_nan = layout.type == SampleType::kFloat32 || layout.type == SampleType::kFloat64;
  return may_be_nan || layout.has_alpha || layout.nodata.has_value();
}

// Indices i of cells of a grid whose centres, `first` + (i + 1/2) `step`, lie from `low` to `high`, as
// [begin, end).
struct Span {
  std::int64_t begin;
  std::int64_t end;
};
Span cells_inside(double first, double step, double low, double high) {
  constexpr double kMargin = 1e-6;  // of a cell: a centre on the edge itself is not sure
  return {static_cast<std::int64_t>(std::ceil((low - first) / step - 0.5 + kMargin)),
          static_cast<std::int64_t>(std::floor((high - first) / step - 0.5 - kMargin)) + 1};
}

// Texels, from the corner of the data rectangle, that a source on a grid of its own gives data to: those
// whose centres lie in the raster. The source lies `moved_x` east of where it says.
TexelRect texels_with_centres_in(const LayerInfo& layer, const OpenSource& source, double moved_x) {
  const geo::GeoTransform& transform = source.transform;
  const double west = transform.x0 + moved_x;
  const source::RasterInfo& info = source.raster->info();
  const GridPlacement& grid = layer.grid;
  const Span columns = cells_inside(grid.origin_x, grid.step_x, west, west + static_cast<double>(info.width) * transform.x_column);
  // Rows count to the south, so distances are from the north.
  const Span rows = cells_inside(0.0, grid.step_y, grid.origin_y - transform.y0,
                                 grid.origin_y - (transform.y0 + static_cast<double>(info.height) * transform.y_row));
  if (columns.end <= columns.begin || rows.end <= rows.begin) return {};
  return intersect({columns.begin, rows.begin, columns.end - columns.begin, rows.end - rows.begin},
                   {0, 0, layer.data.width, layer.data.height});
}

}  // namespace

bool is_surely_covered(const LayerInfo& layer, const geo::Crs& crs, std::span<const OpenSource> sources,
                       std::span<const SourcePlaces> places) {
  std::vector<TexelRect> sure;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t turn = 0; turn < places[i].placed.size(); ++turn) {
      const resample::PlacedSource& placed = places[i].placed[turn];
      if (placed.covered.empty() || may_lack_data(placed.layout)) continue;
      if (placed.is_aligned) {
        sure.push_back(placed.covered);
      } else if (sources[i].transform.is_north_up() && crs.same_coordinates(sources[i].crs)) {
        sure.push_back(texels_with_centres_in(layer, sources[i], places[i].turns[turn] * crs.turn().value_or(0.0)));
      }
    }
  return resample::covers(sure, {0, 0, layer.data.width, layer.data.height});
}

}  // namespace vt::pipeline
