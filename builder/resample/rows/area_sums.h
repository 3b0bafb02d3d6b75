// Sums over the samples under texels, each sample by its covered part: planes by their rules, classes by
// their areas. Sums are in double and taken in one order (rows from north to south, samples from west to
// east), so that they depend on nothing but the texel and its samples. Private to this folder. One object per
// thread, reused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/class_areas.h"
#include "builder/resample/grid/footprint.h"
#include "builder/resample/grid/sample_grid.h"

namespace vt::resample {

// The sums of many texels at once, told apart by number.
class PlaneSums {
 public:
  // Windows that will be added hold all planes of the codec.
  void reset(std::size_t texels, const channels::ChannelCodec& codec);
  // What `run` covers of row `row` of the window, which it lies inside.
  void add(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run);
  [[nodiscard]] bool has_extremes() const { return has_extremes_; }
  // For planes of least and greatest values only.
  void add_extremes(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run);
  // The means over all that was added, as texel `i` of a row; of nothing they are 0. Extremes are of samples
  // that have data.
  void finish(std::size_t texel, const channels::PlaneRow& out, std::int64_t i) const;

 private:
  [[nodiscard]] std::size_t stride() const { return rules_.size() + 1; }
  [[nodiscard]] const double* weights_of(const SampleWindow& window, std::int64_t row, const CoveredRun& run);

  std::vector<channels::PlaneRule> rules_;
  std::size_t weight_plane_ = 0;
  bool has_extremes_ = false;
  std::vector<float> nothing_;  // planes of a texel without data
  std::vector<double> sums_;    // of each texel its planes, then the area
  std::vector<double> weights_;
};

// The same where planes are class and weight (channels/class_planes.h).
class ClassSums {
 public:
  void reset(std::size_t texels);
  void add(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run);
  // The shares of the part of the footprint that lies in a raster; the list is gone afterwards.
  [[nodiscard]] std::span<const channels::ClassArea> finish(std::size_t texel);

 private:
  std::vector<std::vector<channels::ClassArea>> lists_;
  std::vector<double> inside_;
};

// One row of texels whose edges run along those of samples: rows of samples are added up first, each as a
// whole, and then columns.
class ColumnSums {
 public:
  // For columns `first` to `first + count` of windows; forgets what was added before.
  void reset(std::int64_t first, std::int64_t count, const channels::ChannelCodec& codec);
  // The window's columns are those of reset(). `covered` counts for sums, `touched` for least and greatest
  // values.
  void add_row(const SampleWindow& window, std::int64_t row, double covered, double touched);
  // The means over the columns of `run`, the extremes over those of `touched`, as texel `i` of a row. False,
  // and nothing is written: the run covers no raster.
  void finish(const CoveredRun& run, const CoveredRun& touched, const channels::PlaneRow& out, std::int64_t i) const;

 private:
  [[nodiscard]] double* sums_of(std::size_t plane) { return sums_.data() + plane * static_cast<std::size_t>(count_); }
  [[nodiscard]] const double* sums_of(std::size_t plane) const { return sums_.data() + plane * static_cast<std::size_t>(count_); }

  std::int64_t first_ = 0;
  std::int64_t count_ = 0;
  std::vector<channels::PlaneRule> rules_;
  std::size_t weight_plane_ = 0;
  std::vector<float> nothing_;  // planes of a texel without data
  double rows_ = 0.0;           // the area of a column that is all there
  std::vector<double> sums_;    // plane after plane; instead of the weights' sum what they lack to `rows_`, and of the area likewise
};

}  // namespace vt::resample
