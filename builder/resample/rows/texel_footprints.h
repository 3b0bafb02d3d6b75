// The texels of a part of a layer in the samples of a grid of sources: where they lie, whether a source is
// there, and which way each is made. Private to this folder. One object per thread, reused.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/resample/grid/footprint.h"
#include "builder/resample/grid/grid_sources.h"
#include "builder/resample/rows/texel_block.h"

namespace vt::resample {

// Samples per texel up to which a footprint is one sample. Sources of equal resolution, whose ratio goes from
// 0.97 to 1.03 over a scene, are made in one way all over, and a sample counts for at most 2 sinc^2(1 /
// ratio) = 0.2 % more or less than its area.
inline constexpr double kMostUnit = 1.0 + 1.0 / 32.0;
// The same for the sample that is nearest.
inline constexpr double kMostPicked = 1.0 + 1.0 / 16.0;

class TexelFootprints {
 public:
  enum class Kind : std::uint8_t { kNothing, kOneSample, kArea };

  // `alone`: no other sources are seen in `part`; then texels whose centre lies in no source have nothing.
  // Otherwise those that lie in none with any place, and `out`, when it is given, is told which of them do.
  void find(const GridSources& sources, const TexelRect& part, bool alone, TexelBlock* out);

  [[nodiscard]] bool has(Kind kind) const { return kind == Kind::kArea ? has_areas_ : has_units_; }
  // Texels of a row of the part from column `x` on.
  [[nodiscard]] const Kind* kinds(std::int64_t x, std::int64_t y) const { return &kinds_[index_of(x, y)]; }
  [[nodiscard]] const Point2* centres(std::int64_t x, std::int64_t y) const { return &centres_[index_of(x, y)]; }
  // What a texel of kArea is the mean of.
  [[nodiscard]] Quad footprint(std::int64_t x, std::int64_t y) const;
  // Texels along which rows of samples rise or fall by about as many samples as a third of the part is high:
  // wider pieces of it would need much more of the source than lies under them.
  [[nodiscard]] std::int64_t fitting_width() const;

 private:
  [[nodiscard]] std::size_t index_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y - part_.y) * part_.width + (x - part_.x));
  }
  [[nodiscard]] Quad corners(std::int64_t x, std::int64_t y) const;
  void find_positions();
  void leave_out_the_rest(TexelBlock* out);
  [[nodiscard]] bool is_filled(const TexelRect& piece);
  void locate(std::int64_t x, std::int64_t y, TexelBlock* out);
  [[nodiscard]] bool is_in_a_source(const Point2& p) const;
  [[nodiscard]] std::uint64_t places_of(const Quad& quad) const;

  const GridSources* sources_ = nullptr;
  TexelRect part_;
  bool alone_ = true;
  bool has_units_ = false;
  bool has_areas_ = false;
  std::vector<Point2> centres_;
  std::vector<Point2> corners_;  // one column and row more; of areas and of mosaics
  std::vector<GridWarp::Patch> patches_;
  std::vector<float> samples_per_texel_;
  std::vector<Kind> kinds_;
  // In the piece that is looked at: the sources near it, or the grid's bounds where they are full of sources.
  std::vector<TexelRect> near_;
  std::vector<std::uint32_t> found_;
};

// Around places in the samples of a grid.
class PlaceBounds {
 public:
  void add(const Point2& p);  // nothing when it is no number
  [[nodiscard]] bool is_empty() const { return !(min_.x <= max_.x); }
  // The samples of `raster` that the places are in, moved into it where they lie outside, and `reach` samples
  // more on every side.
  [[nodiscard]] TexelRect samples_of(const TexelRect& raster, double reach) const;

 private:
  Point2 min_{INFINITY, INFINITY};
  Point2 max_{-INFINITY, -INFINITY};
};

}  // namespace vt::resample
