// Where the texels of a layer's grid fall in a source raster, and how many samples lie under one.
//
// Exact (through the projections) at 3 x 3 nodes of cells that are fixed to the layer's grid, biquadratic
// between them. A cell is believed when four places inside it, where the error of a smooth map is largest,
// lie within kTolerance of the exact map; otherwise it is cut into four, and every point of a cell of
// kLeastCell texels that is still not believed is exact. So the answer does not depend on how work is cut
// into blocks. (A test in the middle of a cell says nothing between two conformal systems: both coordinates
// are harmonic there, and the error of a bilinear cell in its middle, f_xx + f_yy, vanishes whatever it is at
// the edges.) Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "store/layer.h"
#include "store/vt_mapping.h"

namespace vt::resample {

class GridWarp {
 public:
  static constexpr double kTolerance = 1.0 / 1024.0;  // source samples; of a texel where that is larger
  static constexpr std::int64_t kCellWidth = 64;      // texels
  static constexpr std::int64_t kCellHeight = 32;     // rows that are read at once share no cell with others
  static constexpr std::int64_t kLeastCell = 4;

  // Texels on which the map is equally coarse.
  struct Patch {
    TexelRect texels;
    // The greatest singular value of the map's derivative: over so many samples at most leads a step of one
    // texel. 0: no answer.
    double samples_per_texel = 1.0;
  };

  // From texels of the grid (continuous, column 0 at the west edge of the data rectangle) to the source's
  // columns and rows. `turns`: the source is meant so many times round the globe to the east of where it says
  // it lies.
  GridWarp(const GridPlacement& grid, geo::Crs grid_crs, const geo::GeoTransform& source, geo::Crs source_crs, int turns = 0);

  // NaN where the projections have no answer.
  [[nodiscard]] Point2 exact(Point2 texel) const;
  // Source positions of the centres of all texels of `rect`, row by row, tightly packed. `patches`, when
  // given, is replaced by rectangles that cover `rect` once.
  void map_centres(const TexelRect& rect, std::span<Point2> out, std::vector<Patch>* patches = nullptr) const;
  // Those of the corners: one more column and row.
  void map_corners(const TexelRect& rect, std::span<Point2> out) const;

  // Texel edges run along sample edges, columns to the east and rows to the south: column edges depend on the
  // texel's column alone.
  [[nodiscard]] bool is_axis_aligned() const { return same_crs_ && source_.is_north_up(); }
  // The most of any texel of `rect`: exact where the grids share a coordinate system, otherwise found at a
  // few places.
  [[nodiscard]] double most_samples_per_texel(const TexelRect& rect) const;

  // Where the first sample of `other` lies among the samples of this source, in whole samples, when all
  // samples of a raster of `other_width` x `other_height` lie on this source's, to kSameGrid samples. nullopt
  // when they do not.
  static constexpr double kSameGrid = 1e-4;
  struct SampleOffset {
    std::int64_t x = 0;
    std::int64_t y = 0;
  };
  [[nodiscard]] std::optional<SampleOffset> offset_of(const GridWarp& other, std::int64_t other_width, std::int64_t other_height) const;

  // Everything that decides the answers, as text: two warps with the same facts give the same positions.
  [[nodiscard]] const std::string& facts() const { return facts_; }

 private:
  struct Cell {
    TexelRect texels;
    std::array<Point2, 9> node;  // row by row
  };
  // Points of a grid of texels, at `offset` texels from their north-western corners.
  struct Points {
    TexelRect rect;
    double offset;
    std::span<Point2> out;
  };

  void map(const Points& points, std::vector<Patch>* patches) const;
  void map_cell(const TexelRect& texels, const Points& points, std::vector<Patch>* patches) const;
  [[nodiscard]] Cell cell_at(const TexelRect& texels) const;
  [[nodiscard]] bool is_believed(const Cell& cell, double tolerance) const;

  GridPlacement grid_;
  geo::Crs grid_crs_;
  geo::GeoTransform source_;
  geo::GeoTransform raster_from_source_crs_;
  geo::Crs source_crs_;
  bool same_crs_;
  int turns_;
  double moved_;                 // by `turns`, to the east: units of the grid if both systems are the same, else degrees
  double affine_stretch_ = 0.0;  // of one coordinate system
  std::string facts_;
};

}  // namespace vt::resample
