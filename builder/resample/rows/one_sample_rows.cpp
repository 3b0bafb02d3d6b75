#include "builder/resample/rows/one_sample_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/channels/samples/wide_value.h"
#include "builder/resample/grid/buffers.h"
#include "builder/resample/rows/row_kernels.h"

namespace vt::resample {

using channels::PlaneRow;

void OneSampleRows::make(const GridSources& sources, const SampleWindow& window, const TexelFootprints& texels, std::int64_t x,
                         std::int64_t y, std::int64_t count, const PlaneRow& out) {
  const Kind* const kinds = texels.kinds(x, y);
  const Point2* const centres = texels.centres(x, y);
  const auto texel_count = static_cast<std::size_t>(count);
  if (sources.method == Method::kNearest) {
    pick(window.block, kinds, centres, texel_count, out);
  } else {
    find_four(sources.grid.bounds(), window.block, kinds, centres, texel_count);
    interpolate_runs(window, texel_count, out);
    interpolate_wide(sources.codec().rules(), window.block, texel_count, out);
    if (!window.there.empty()) mend_gaps(sources.codec().rules(), window, kinds, texel_count, out);
  }
  sources.codec().derive_row(count, out);
}

void OneSampleRows::find_four(const TexelRect& raster, const PlaneBlock& block, const Kind* kinds, const Point2* centres,
                              std::size_t count) {
  for (std::vector<std::uint32_t>* numbers : {&first_, &down_, &right_}) refit(*numbers, count);
  refit(fraction_x_, count);
  refit(fraction_y_, count);
  const TexelRect& window = block.rect;
  const auto row_floats = static_cast<std::uint32_t>(block.planes * window.width);
  const auto west = static_cast<double>(raster.x);
  const auto north = static_cast<double>(raster.y);
  const auto last_x = static_cast<double>(raster.width - 1);
  const auto last_y = static_cast<double>(raster.height - 1);
  const std::int64_t columns_before = window.x - raster.x;
  const std::int64_t rows_before = window.y - raster.y;
  for (std::size_t i = 0; i < count; ++i) {
    if (kinds[i] != Kind::kOneSample) {
      first_[i] = down_[i] = right_[i] = 0;
      fraction_x_[i] = fraction_y_[i] = 0.0F;
      continue;
    }
    // From the first sample's centre on. Beyond the outermost centres the edge sample goes on.
    const double x = std::clamp(centres[i].x - 0.5 - west, 0.0, last_x);
    const double y = std::clamp(centres[i].y - 0.5 - north, 0.0, last_y);
    const auto column = static_cast<std::int64_t>(x);
    const auto row = static_cast<std::int64_t>(y);
    fraction_x_[i] = static_cast<float>(x - static_cast<double>(column));
    fraction_y_[i] = static_cast<float>(y - static_cast<double>(row));
    first_[i] = static_cast<std::uint32_t>(row - rows_before) * row_floats + static_cast<std::uint32_t>(column - columns_before);
    down_[i] = row - rows_before + 1 < window.height ? row_floats : 0;
    right_[i] = column - columns_before + 1 < window.width ? 1 : 0;
  }
}

// Where texels are about as large as samples, neighbours among them have neighbouring samples for long runs.
void OneSampleRows::interpolate_runs(const SampleWindow& window, std::size_t count, const PlaneRow& out) const {
  const PlaneBlock& block = window.block;
  const auto plane_floats = static_cast<std::size_t>(block.rect.width);
  const std::size_t interpolated = static_cast<std::size_t>(block.planes) - (window.is_opaque ? 1 : 0);
  for (std::size_t first = 0, end = 0; first < count; first = end) {
    for (end = first + 1; end < count; ++end)
      if (first_[end] != first_[end - 1] + 1 || down_[end] != down_[first] || right_[end] != right_[first]) break;
    for (std::size_t p = 0; p < interpolated; ++p) {
      const float* const north_west = block.floats.data() + p * plane_floats + first_[first];
      const float* const south_west = north_west + down_[first];
      interpolate(
          {&fraction_x_[first], &fraction_y_[first], north_west, north_west + right_[first], south_west, south_west + right_[first]},
          end - first, out[p] + first);
    }
  }
  if (window.is_opaque) std::fill_n(out[interpolated], count, 1.0F);
}

// Again, in double, what a float and its remainder hold together.
void OneSampleRows::interpolate_wide(std::span<const channels::PlaneRule> rules, const PlaneBlock& block, std::size_t count,
                                     const PlaneRow& out) const {
  const auto plane_floats = static_cast<std::size_t>(block.rect.width);
  for (std::size_t p = 0; p + 1 < static_cast<std::size_t>(block.planes); ++p) {
    if (!channels::has_remainder(rules, p)) continue;
    const float* const values = block.floats.data() + p * plane_floats;
    const auto wide = [&](std::size_t at) { return static_cast<double>(values[at]) + static_cast<double>(values[at + plane_floats]); };
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = first_[i];
      const double north = std::lerp(wide(at), wide(at + right_[i]), static_cast<double>(fraction_x_[i]));
      const double south = std::lerp(wide(at + down_[i]), wide(at + down_[i] + right_[i]), static_cast<double>(fraction_x_[i]));
      channels::split_wide(std::lerp(north, south, static_cast<double>(fraction_y_[i])), out[p][i], out[p + 1][i]);
    }
  }
}

// Texels of which some of the four samples lie in no raster are made of the others.
void OneSampleRows::mend_gaps(std::span<const channels::PlaneRule> rules, const SampleWindow& window, const Kind* kinds, std::size_t count,
                              const PlaneRow& out) const {
  const PlaneBlock& block = window.block;
  const auto width = static_cast<std::size_t>(block.rect.width);
  const std::size_t row_floats = width * static_cast<std::size_t>(block.planes);
  for (std::size_t i = 0; i < count; ++i) {
    if (kinds[i] != Kind::kOneSample) continue;
    const std::array<std::size_t, 4> at{first_[i], first_[i] + right_[i], first_[i] + down_[i], first_[i] + down_[i] + right_[i]};
    std::array<bool, 4> is_there{};
    for (std::size_t k = 0; k < 4; ++k) is_there[k] = window.there[at[k] / row_floats * width + at[k] % row_floats] != 0;
    if (std::ranges::all_of(is_there, [](bool one) { return one; })) continue;
    // Where a whole column or row is missing its neighbours stay as they are.
    float fx = fraction_x_[i];
    float fy = fraction_y_[i];
    if (!is_there[0] && !is_there[2]) fx = 1.0F;
    if (!is_there[1] && !is_there[3]) fx = 0.0F;
    if (!is_there[0] && !is_there[1]) fy = 1.0F;
    if (!is_there[2] && !is_there[3]) fy = 0.0F;
    const std::array<float, 4> weight{(1.0F - fx) * (1.0F - fy), fx * (1.0F - fy), (1.0F - fx) * fy, fx * fy};
    float sum = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) sum += is_there[k] ? weight[k] : 0.0F;
    for (std::size_t p = 0; p < static_cast<std::size_t>(block.planes); ++p) {
      float value = 0.0F;
      for (std::size_t k = 0; k < 4; ++k)
        if (is_there[k]) value += weight[k] * block.floats[p * width + at[k]];
      out[p][i] = sum > 0.0F ? value / sum : 0.0F;
      if (!channels::has_remainder(rules, p)) continue;
      double wide = 0.0;
      double weights = 0.0;
      for (std::size_t k = 0; k < 4; ++k) {
        if (!is_there[k]) continue;
        const float* const both = &block.floats[p * width + at[k]];
        wide += static_cast<double>(weight[k]) * (static_cast<double>(both[0]) + static_cast<double>(both[width]));
        weights += static_cast<double>(weight[k]);
      }
      channels::split_wide(weights > 0.0 ? wide / weights : 0.0, out[p][i], out[p + 1][i]);
      ++p;
    }
  }
}

void OneSampleRows::pick(const PlaneBlock& block, const Kind* kinds, const Point2* centres, std::size_t count, const PlaneRow& out) {
  const TexelRect& window = block.rect;
  for (std::size_t i = 0; i < count; ++i) {
    std::int64_t at = 0;
    const bool is_one = kinds[i] == Kind::kOneSample;
    if (is_one)
      at = (static_cast<std::int64_t>(std::floor(centres[i].y)) - window.y) * block.planes * window.width +
           static_cast<std::int64_t>(std::floor(centres[i].x)) - window.x;
    for (int p = 0; p < block.planes; ++p)
      out[static_cast<std::size_t>(p)][i] = is_one ? block.floats[static_cast<std::size_t>(at + p * window.width)] : 0.0F;
  }
}

}  // namespace vt::resample
