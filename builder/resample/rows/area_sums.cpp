#include "builder/resample/rows/area_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/channels/samples/wide_value.h"
#include "builder/resample/rows/row_kernels.h"

namespace vt::resample {
namespace {

using channels::PlaneRow;
using channels::PlaneRule;

double start_of(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::kLinear:
    case PlaneRule::kRemainder:
      break;
    case PlaneRule::kLeast:
      return std::numeric_limits<double>::infinity();
    case PlaneRule::kGreatest:
      return -std::numeric_limits<double>::infinity();
  }
  return 0.0;
}

bool is_extreme(PlaneRule rule) { return !is_sum(rule); }

// Where there is none, that of a texel without data.
float extreme_or(double found, float nothing) { return std::isinf(found) ? nothing : static_cast<float>(found); }

double extreme(PlaneRule rule, double a, double b) { return rule == PlaneRule::kLeast ? std::min(a, b) : std::max(a, b); }

// Instead of values.
struct Ones {
  double operator[](std::size_t) const { return 1.0; }
};

// What is there of each column of so many rows, of which `lacking` are not.
struct Rest {
  const double* lacking;
  double rows;
  double operator[](std::size_t i) const { return rows - lacking[i]; }
};

// The sum of weights[i] * values[i], in four interleaved sums: one after the other the additions would wait
// for each other.
template <class Values>
double weighted_sum(const double* weights, const Values& values, std::size_t count) {
  double sum[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t k = 0; k < 4; ++k) sum[k] += weights[i + k] * static_cast<double>(values[i + k]);
  for (; i < count; ++i) sum[0] += weights[i] * static_cast<double>(values[i]);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

}  // namespace

void PlaneSums::reset(std::size_t texels, const channels::ChannelCodec& codec) {
  rules_.assign(codec.rules().begin(), codec.rules().end());
  weight_plane_ = static_cast<std::size_t>(codec.weight_plane());
  nothing_ = planes_of_nothing(codec);
  has_extremes_ = std::ranges::any_of(rules_, is_extreme);
  sums_.resize(texels * stride());
  for (std::size_t at = 0; at < sums_.size(); at += stride()) {
    std::ranges::transform(rules_, sums_.begin() + static_cast<std::ptrdiff_t>(at), start_of);
    sums_[at + rules_.size()] = 0.0;
  }
}

// Nothing of samples that lie in no raster.
const double* PlaneSums::weights_of(const SampleWindow& window, std::int64_t row, const CoveredRun& run) {
  const std::uint8_t* const there = window.there_at(run.first, row);
  if (there == nullptr) return run.covered.data();
  weights_.resize(run.covered.size());
  for (std::size_t i = 0; i < weights_.size(); ++i) weights_[i] = there[i] != 0 ? run.covered[i] : 0.0;
  return weights_.data();
}

void PlaneSums::add(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run) {
  const std::size_t count = run.covered.size();
  const double* const weights = weights_of(window, row, run);
  double* const sums = &sums_[texel * stride()];
  const double area = weighted_sum(weights, Ones{}, count);
  sums[rules_.size()] += area;
  const float* plane = window.block.first_plane(run.first, row);
  for (std::size_t p = 0; p < rules_.size(); ++p, plane += window.block.rect.width) {
    if (is_extreme(rules_[p])) continue;
    sums[p] += p == weight_plane_ && window.is_opaque ? area : weighted_sum(weights, plane, count);
  }
  add_extremes(texel, window, row, run);
}

void PlaneSums::add_extremes(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run) {
  if (!has_extremes_) return;
  const double* const weights = weights_of(window, row, run);
  const std::int64_t plane_floats = window.block.rect.width;
  const float* const planes = window.block.first_plane(run.first, row);
  const float* const has_data = planes + static_cast<std::int64_t>(weight_plane_) * plane_floats;
  double* const sums = &sums_[texel * stride()];
  for (std::size_t p = 0; p < rules_.size(); ++p) {
    if (!is_extreme(rules_[p])) continue;
    const float* const values = planes + static_cast<std::int64_t>(p) * plane_floats;
    for (std::size_t c = 0; c < run.covered.size(); ++c)
      if (weights[c] > kLeastTouch && has_data[c] > 0.0F) sums[p] = extreme(rules_[p], sums[p], static_cast<double>(values[c]));
  }
}

void PlaneSums::finish(std::size_t texel, const PlaneRow& out, std::int64_t i) const {
  const double* const sums = &sums_[texel * stride()];
  const double area = sums[rules_.size()];
  for (std::size_t p = 0; p < rules_.size(); ++p) {
    if (is_extreme(rules_[p])) {
      out[p][i] = extreme_or(sums[p], nothing_[p]);
    } else if (channels::has_remainder(rules_, p)) {
      channels::split_wide(area > 0.0 ? (sums[p] + sums[p + 1]) / area : 0.0, out[p][i], out[p + 1][i]);
      ++p;
    } else {
      out[p][i] = area > 0.0 ? static_cast<float>(sums[p] / area) : 0.0F;
    }
  }
}

void ClassSums::reset(std::size_t texels) {
  if (lists_.size() < texels) lists_.resize(texels);
  for (std::vector<channels::ClassArea>& list : lists_) list.clear();
  inside_.assign(texels, 0.0);
}

void ClassSums::add(std::size_t texel, const SampleWindow& window, std::int64_t row, const CoveredRun& run) {
  const channels::ConstPlaneRow planes = window.block.row_at(run.first, row);
  const float* const ids = planes[0];
  const float* const weights = planes[channels::kClassWeightPlane];
  const std::uint8_t* const there = window.there_at(run.first, row);
  std::vector<channels::ClassArea>& list = lists_[texel];
  // Neighbours of one class are one entry.
  double same = 0.0;
  float id = 0.0F;
  for (std::size_t i = 0; i < run.covered.size(); ++i) {
    if (there != nullptr && there[i] == 0) continue;
    inside_[texel] += run.covered[i];
    if (!(weights[i] > 0.0F)) continue;
    if (ids[i] != id && same > 0.0) {
      channels::add_class_area(list, id, same);
      same = 0.0;
    }
    id = ids[i];
    same += run.covered[i];
  }
  if (same > 0.0) channels::add_class_area(list, id, same);
}

std::span<const channels::ClassArea> ClassSums::finish(std::size_t texel) {
  for (channels::ClassArea& entry : lists_[texel]) entry.area /= inside_[texel];
  return lists_[texel];
}

void ColumnSums::reset(std::int64_t first, std::int64_t count, const channels::ChannelCodec& codec) {
  first_ = first;
  count_ = count;
  rules_.assign(codec.rules().begin(), codec.rules().end());
  weight_plane_ = static_cast<std::size_t>(codec.weight_plane());
  nothing_ = planes_of_nothing(codec);
  rows_ = 0.0;
  sums_.resize((rules_.size() + 1) * static_cast<std::size_t>(count));
  for (std::size_t p = 0; p <= rules_.size(); ++p) std::fill_n(sums_of(p), count, p < rules_.size() ? start_of(rules_[p]) : 0.0);
}

void ColumnSums::add_row(const SampleWindow& window, std::int64_t row, double covered, double touched) {
  const float* const planes = window.block.first_plane(first_, row);
  const auto plane = [&](std::size_t p) { return planes + static_cast<std::int64_t>(p) * window.block.rect.width; };
  const float* const weight = plane(weight_plane_);
  for (std::size_t p = 0; p < rules_.size(); ++p) {
    double* const sums = sums_of(p);
    if (is_extreme(rules_[p])) {
      const float* const values = plane(p);
      for (std::int64_t c = 0; c < count_ && touched > kLeastTouch; ++c)
        if (weight[c] > 0.0F) sums[c] = extreme(rules_[p], sums[c], static_cast<double>(values[c]));
    } else if (p != weight_plane_) {
      add_weighted(plane(p), covered, static_cast<std::size_t>(count_), sums);
    } else if (!window.is_opaque) {
      for (std::int64_t c = 0; c < count_; ++c) sums[c] += covered * (1.0 - static_cast<double>(weight[c]));
    }
  }
  rows_ += covered;
  const std::uint8_t* const there = window.there_at(first_, row);
  double* const lacking = sums_of(rules_.size());
  for (std::int64_t c = 0; there != nullptr && c < count_; ++c) lacking[c] += there[c] != 0 ? 0.0 : covered;
}

void ColumnSums::finish(const CoveredRun& run, const CoveredRun& touched, const PlaneRow& out, std::int64_t i) const {
  const std::size_t count = run.covered.size();
  const double* const covered = run.covered.data();
  const auto columns = [&](std::size_t p) { return sums_of(p) + (run.first - first_); };
  const double area = weighted_sum(covered, Rest{columns(rules_.size()), rows_}, count);
  for (std::size_t p = 0; p < rules_.size(); ++p) {
    if (channels::has_remainder(rules_, p)) {
      const double sum = weighted_sum(covered, columns(p), count) + weighted_sum(covered, columns(p + 1), count);
      channels::split_wide(area > 0.0 ? sum / area : 0.0, out[p][i], out[p + 1][i]);
      ++p;
      continue;
    }
    if (!is_extreme(rules_[p])) {
      const double sum =
          p == weight_plane_ ? weighted_sum(covered, Rest{columns(p), rows_}, count) : weighted_sum(covered, columns(p), count);
      out[p][i] = area > 0.0 ? static_cast<float>(sum / area) : 0.0F;
      continue;
    }
    double most = start_of(rules_[p]);
    for (std::size_t c = 0; c < touched.covered.size(); ++c)
      if (touched.covered[c] > kLeastTouch)
        most = extreme(rules_[p], most, sums_of(p)[touched.first - first_ + static_cast<std::int64_t>(c)]);
    out[p][i] = extreme_or(most, nothing_[p]);
  }
}

}  // namespace vt::resample
