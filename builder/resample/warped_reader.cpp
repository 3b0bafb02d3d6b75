#include "builder/resample/warped_reader.h"

#include <algorithm>

#include "builder/resample/grid/buffers.h"

namespace vt::resample {
namespace {

using channels::PlaneRow;
using Kind = TexelFootprints::Kind;

// One part of a layer from the sources of one grid.
class Reader {
 public:
  // `out` and `content` may be null: the first when nothing is to be decoded.
  Reader(const GridSources& sources, const TexelRect& part, bool alone, WarpBuffers& buffers, TexelBlock* out,
         store::ContentHasher* content)
      : sources_(sources), raster_(sources.grid.bounds()), part_(part), b_(buffers), out_(out), content_(content) {
    b_.texels.find(sources, part, alone, out);
  }

  Result<void> run() {
    if (b_.texels.has(Kind::kOneSample)) VT_CHECK(read_units(part_));
    if (b_.texels.has(Kind::kArea)) VT_CHECK(read_areas(part_));
    return {};
  }

 private:
  template <class Use>
  void for_each_texel(const TexelRect& piece, Kind kind, const Use& use) const {
    for (std::int64_t y = piece.y; y < piece.bottom(); ++y) {
      const Kind* const kinds = b_.texels.kinds(piece.x, y);
      for (std::int64_t i = 0; i < piece.width; ++i)
        if (kinds[i] == kind) use(piece.x + i, y);
    }
  }

  // Reads (or only hashes) a window.
  Result<void> load(const TexelRect& window, bool derived) {
    if (out_ == nullptr) return sources_.grid.hash(window, b_.window, *content_);
    return sources_.grid.read(window, derived, b_.window, content_);
  }

  template <class Read>
  static Result<void> in_halves(const TexelRect& piece, bool across, const Read& read) {
    TexelRect first = piece;
    TexelRect second = piece;
    if (across) {
      first.width /= 2;
      second.x += first.width;
      second.width -= first.width;
    } else {
      first.height /= 2;
      second.y += first.height;
      second.height -= first.height;
    }
    VT_CHECK(read(first));
    return read(second);
  }

  // A turned or finer source makes a window large: the piece is cut until it is not.
  Result<void> read_units(const TexelRect& piece) {
    PlaceBounds bounds;
    for_each_texel(piece, Kind::kOneSample, [&](std::int64_t x, std::int64_t y) { bounds.add(*b_.texels.centres(x, y)); });
    if (bounds.is_empty()) return {};
    const TexelRect window = bounds.samples_of(raster_, sources_.method == Method::kBilinear ? 0.5 : 0.0);
    if (window.width * window.height > kMostWindowSamples && piece.width * piece.height > 1)
      return in_halves(piece, piece.width >= piece.height, [&](const TexelRect& half) { return read_units(half); });
    VT_CHECK(load(window, false));
    if (out_ == nullptr) return {};
    for (std::int64_t y = piece.y; y < piece.bottom(); ++y) make_unit_row(piece.x, y, piece.width);
    return {};
  }

  void make_unit_row(std::int64_t x, std::int64_t y, std::int64_t count) {
    const Kind* const kinds = b_.texels.kinds(x, y);
    const auto units = std::count(kinds, kinds + count, Kind::kOneSample);
    if (units == 0) return;
    // Where all texels of a row are made this way they are made in their place.
    if (units == count && !out_->has_areas) {
      b_.one_sample.make(sources_, b_.window, b_.texels, x, y, count, out_->block.row_at(x, y));
      return;
    }
    const auto planes = static_cast<std::size_t>(sources_.codec().planes());
    refit(b_.row, planes * static_cast<std::size_t>(count));
    PlaneRow made{};
    for (std::size_t p = 0; p < planes; ++p) made[p] = b_.row.data() + static_cast<std::int64_t>(p) * count;
    b_.one_sample.make(sources_, b_.window, b_.texels, x, y, count, made);
    const PlaneRow target = out_->has_areas ? PlaneRow{} : out_->block.row_at(x, y);
    for (std::int64_t i = 0; i < count; ++i) {
      if (kinds[i] != Kind::kOneSample) continue;
      if (out_->has_areas) {
        const channels::ClassArea all{made[0][i], 1.0};
        if (made[channels::kClassWeightPlane][i] > 0.0F) out_->areas.set(x + i, y, {&all, 1});
      } else {
        for (std::size_t p = 0; p < planes; ++p) target[p][i] = made[p][i];
      }
    }
  }

  Result<void> read_areas(const TexelRect& whole) {
    const bool is_box = sources_.warp->is_axis_aligned() && !sources_.counts_areas;
    const std::int64_t sums = sources_.codec().planes() + 1;
    const std::int64_t width =
        is_box ? whole.width : std::min(b_.texels.fitting_width(), std::max(kMostSums / (sums * whole.height), std::int64_t{1}));
    for (std::int64_t x = whole.x; x < whole.right(); x += width)
      VT_CHECK(read_area_piece(intersect(whole, {x, whole.y, width, whole.height}), is_box));
    return {};
  }

  Result<void> read_area_piece(const TexelRect& piece, bool is_box) {
    PlaceBounds bounds;
    for_each_texel(piece, Kind::kArea, [&](std::int64_t x, std::int64_t y) { add_reach(x, y, bounds); });
    if (bounds.is_empty()) return {};
    const TexelRect window = bounds.samples_of(raster_, 0.0);
    const bool is_too_wide = window.width > kMostWindowSamples || (is_box && window.width * (sources_.codec().planes() + 1) > kMostSums);
    if (is_too_wide && piece.width > 1) return in_halves(piece, true, [&](const TexelRect& half) { return read_area_piece(half, is_box); });
    if (is_box) return read_boxes(piece, window);
    const auto texels = static_cast<std::size_t>(piece.width * piece.height);
    if (sources_.counts_areas) {
      b_.class_sums.reset(texels);
      return read_footprints(piece, window, b_.class_sums);
    }
    b_.plane_sums.reset(texels, sources_.codec());
    return read_footprints(piece, window, b_.plane_sums);
  }

  // All that a texel may be made of.
  void add_reach(std::int64_t x, std::int64_t y, PlaceBounds& bounds) const {
    const Quad quad = b_.texels.footprint(x, y);
    for (const Point2& corner : quad.corner) bounds.add(corner);
    if (!sources_.is_surface()) return;
    const Point2& centre = *b_.texels.centres(x, y);
    const Point2 widths = quad.widths();
    for (const double side : {-0.5, 0.5})
      bounds.add({centre.x + side * (std::max(1.0, widths.x) + 1.0), centre.y + side * (std::max(1.0, widths.y) + 1.0)});
  }

  // How a texel whose edges run along those of samples is made along one axis: what counts for sums, and what
  // for extremes.
  struct AxisRuns {
    CoveredRun sums;
    CoveredRun touched;
  };
  [[nodiscard]] AxisRuns axis_runs(double low, double high, double centre, double width, std::int64_t first, std::int64_t end) const {
    AxisRuns runs{covered_run(low, high), {}};
    runs.touched = runs.sums;
    if (sources_.is_surface()) {
      runs.sums = surface_run(centre, width, first, end);
      runs.touched = united(runs.touched, runs.sums);
    }
    return runs;
  }

  // Each row of samples is added to the rows of texels that it lies under, as a whole.
  Result<void> read_boxes(const TexelRect& piece, const TexelRect& window) {
    const std::int64_t band_rows = std::max<std::int64_t>(1, kMostWindowSamples / window.width);
    const auto width = static_cast<std::size_t>(piece.width);
    b_.columns.resize(std::max(b_.columns.size(), width));
    b_.touched_columns.resize(b_.columns.size());
    for (std::size_t i = 0; i < width; ++i) {
      const std::int64_t x = piece.x + static_cast<std::int64_t>(i);
      const Quad quad = b_.texels.footprint(x, piece.y);
      AxisRuns runs =
          axis_runs(quad.corner[0].x, quad.corner[1].x, b_.texels.centres(x, piece.y)->x, quad.widths().x, raster_.x, raster_.right());
      clip(runs.sums, window.x, window.right());
      clip(runs.touched, window.x, window.right());
      b_.columns[i] = std::move(runs.sums);
      b_.touched_columns[i] = std::move(runs.touched);
    }
    TexelRect band{window.x, 0, window.width, 0};
    for (std::int64_t y = piece.y; y < piece.bottom(); ++y) {
      const Quad quad = b_.texels.footprint(piece.x, y);
      AxisRuns rows =
          axis_runs(quad.corner[0].y, quad.corner[3].y, b_.texels.centres(piece.x, y)->y, quad.widths().y, raster_.y, raster_.bottom());
      clip(rows.touched, window.y, window.bottom());
      b_.column_sums.reset(window.x, window.width, sources_.codec());
      for (std::int64_t row = rows.touched.first; row < rows.touched.end(); ++row) {
        if (row < band.y || row >= band.bottom()) {
          band.y = row;
          band.height = std::min(band_rows, window.bottom() - row);
          VT_CHECK(load(band, true));
        }
        if (out_ != nullptr) b_.column_sums.add_row(b_.window, row, rows.sums.of(row), rows.touched.of(row));
      }
      if (out_ == nullptr) continue;
      const PlaneRow target = out_->block.row_at(piece.x, y);
      const Kind* const kinds = b_.texels.kinds(piece.x, y);
      for (std::size_t i = 0; i < width; ++i)
        if (kinds[i] == Kind::kArea) b_.column_sums.finish(b_.columns[i], b_.touched_columns[i], target, static_cast<std::int64_t>(i));
    }
    return {};
  }

  template <class Sums>
  Result<void> read_footprints(const TexelRect& piece, const TexelRect& window, Sums& sums) {
    const auto number_of = [&](std::int64_t x, std::int64_t y) {
      return static_cast<std::size_t>((y - piece.y) * piece.width + (x - piece.x));
    };
    const std::int64_t band_rows = std::max<std::int64_t>(1, kMostWindowSamples / window.width);
    for (std::int64_t row = window.y; row < window.bottom(); row += band_rows) {
      const TexelRect band{window.x, row, window.width, std::min(band_rows, window.bottom() - row)};
      VT_CHECK(load(band, true));
      if (out_ == nullptr) continue;
      for_each_texel(piece, Kind::kArea, [&](std::int64_t x, std::int64_t y) {
        add_band(b_.texels.footprint(x, y), *b_.texels.centres(x, y), band, number_of(x, y), sums);
      });
    }
    if (out_ != nullptr) for_each_texel(piece, Kind::kArea, [&](std::int64_t x, std::int64_t y) { finish(sums, number_of(x, y), x, y); });
    return {};
  }

  // What of a footprint lies in a band of rows.
  void add_band(const Quad& quad, const Point2&, const TexelRect& band, std::size_t texel, ClassSums& sums) {
    for_each_covered_row(quad, band, [&](std::int64_t row) { sums.add(texel, b_.window, row, b_.run); });
  }
  void add_band(const Quad& quad, const Point2& centre, const TexelRect& band, std::size_t texel, PlaneSums& sums) {
    if (!sources_.is_surface()) {
      for_each_covered_row(quad, band, [&](std::int64_t row) { sums.add(texel, b_.window, row, b_.run); });
      return;
    }
    // Least and greatest values are also of what lies under a turned texel's corners.
    if (sums.has_extremes()) for_each_covered_row(quad, band, [&](std::int64_t row) { sums.add_extremes(texel, b_.window, row, b_.run); });
    const Point2 widths = quad.widths();
    CoveredRun columns = surface_run(centre.x, widths.x, raster_.x, raster_.right());
    CoveredRun rows = surface_run(centre.y, widths.y, raster_.y, raster_.bottom());
    clip(columns, band.x, band.right());
    clip(rows, band.y, band.bottom());
    for (std::int64_t row = rows.first; row < rows.end(); ++row) {
      b_.run = columns;
      for (double& covered : b_.run.covered) covered *= rows.of(row);
      sums.add(texel, b_.window, row, b_.run);
    }
  }

  // Calls use(row) with what is covered of each row in b_.run.
  template <class Use>
  void for_each_covered_row(const Quad& quad, const TexelRect& band, const Use& use) {
    if (quad.greatest_y() <= static_cast<double>(band.y) || quad.least_y() >= static_cast<double>(band.bottom())) return;
    const QuadCoverage coverage(quad);
    for (std::int64_t row = std::max(band.y, coverage.first_row()); row < std::min(band.bottom(), coverage.end_row()); ++row) {
      coverage.row(row, b_.run);
      clip(b_.run, band.x, band.right());
      if (!b_.run.covered.empty()) use(row);
    }
  }

  void finish(PlaneSums& sums, std::size_t texel, std::int64_t x, std::int64_t y) { sums.finish(texel, out_->block.row_at(x, y), 0); }
  void finish(ClassSums& sums, std::size_t texel, std::int64_t x, std::int64_t y) { out_->areas.set(x, y, sums.finish(texel)); }

  const GridSources& sources_;
  TexelRect raster_;  // all samples of the grid
  TexelRect part_;
  WarpBuffers& b_;
  TexelBlock* out_;
  store::ContentHasher* content_;
};

}  // namespace

Result<void> read_warped(const GridSources& sources, const TexelRect& part, bool alone, WarpBuffers& buffers, TexelBlock& out,
                         store::ContentHasher* content) {
  if (content != nullptr) add_warp_mark(*sources.warp, sources.method, part, *content);
  return Reader(sources, part, alone, buffers, &out, content).run();
}

Result<void> hash_warped(const GridSources& sources, const TexelRect& part, bool alone, WarpBuffers& buffers,
                         store::ContentHasher& content) {
  add_warp_mark(*sources.warp, sources.method, part, content);
  return Reader(sources, part, alone, buffers, nullptr, &content).run();
}

}  // namespace vt::resample
