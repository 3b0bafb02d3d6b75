// The definition of an overview, whole level at once and texel by texel: short enough that reading it is
// checking it. What the builder makes block by block with SIMD rows must equal this bit for bit.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/pyramid/layer_shape.h"
#include "store/tile_id.h"

namespace vt::test {

// `rules` of all planes; none given: all linear, the last is the weight.
struct PlaneRules {
  std::vector<channels::PlaneRule> rules;
  int weight_plane = 0;

  [[nodiscard]] static PlaneRules linear(int planes) {
    return {std::vector<channels::PlaneRule>(static_cast<std::size_t>(planes), channels::PlaneRule::kLinear), planes - 1};
  }
  [[nodiscard]] channels::PlaneRule operator[](int plane) const { return rules[static_cast<std::size_t>(plane)]; }
  // What a plane holds where there are no data.
  [[nodiscard]] float nothing(int plane) const {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const channels::PlaneRule rule = rules[static_cast<std::size_t>(plane)];
    return rule == channels::PlaneRule::kLeast ? kInfinity : rule == channels::PlaneRule::kGreatest ? -kInfinity : 0.0F;
  }
};

// All planes of one level.
struct WholeImage {
  pyramid::LayerShape layer;
  int depth = 0;  // levels above the layer's finest
  TexelRect data;
  int planes;
  std::vector<float> floats;

  // The finest level of a layer that ends at its edges.
  WholeImage(const TexelRect& rect, int plane_count) : WholeImage(pyramid::LayerShape{.data = rect}, 0, plane_count) {}
  WholeImage(const pyramid::LayerShape& shape, int level_depth, int plane_count)
      : layer(shape),
        depth(level_depth),
        data(shape.data_at(level_depth)),
        planes(plane_count),
        floats(static_cast<std::size_t>(data.width * data.height * plane_count), 0.0F) {}

  float& at(std::int64_t x, std::int64_t y, int p) { return floats[index(x, y, p)]; }
  // Zero outside the data rectangle.
  [[nodiscard]] float get(std::int64_t x, std::int64_t y, int p) const { return data.contains(x, y) ? floats[index(x, y, p)] : 0.0F; }
  // Nothing to the north and south of the data rectangle, and to the west and east of a layer that is not
  // closed.
  [[nodiscard]] float seen(std::int64_t x, std::int64_t y, int p, const PlaneRules& rules) const {
    if (data.contains(x, y)) return floats[index(x, y, p)];
    if (!layer.is_closed || y < data.y || y >= data.bottom()) return rules.nothing(p);
    const pyramid::SeamColumn column = layer.column_past_edge(depth, x);
    const float first = floats[index(column.first, y, p)];
    const float second = floats[index(column.second, y, p)];
    if (column.share == 0.0F) return first;
    if (rules[p] == channels::PlaneRule::kLeast) return std::min(first, second);
    if (rules[p] == channels::PlaneRule::kGreatest) return std::max(first, second);
    if (rules[p] == channels::PlaneRule::kRemainder) {
      const auto whole = [&](std::int64_t at) {
        return static_cast<double>(floats[index(at, y, p - 1)]) + static_cast<double>(floats[index(at, y, p)]);
      };
      const double share = column.share;
      const double value = (1.0 - share) * whole(column.first) + share * whole(column.second);
      return static_cast<float>(value - static_cast<double>(seen(x, y, p - 1, rules)));
    }
    return (1.0F - column.share) * first + column.share * second;
  }

 private:
  [[nodiscard]] std::size_t index(std::int64_t x, std::int64_t y, int p) const {
    return static_cast<std::size_t>(((y - data.y) * data.width + (x - data.x)) * planes + p);
  }
};

template <class At>
float weighted_pairs(const pyramid::HalvingKernel& kernel, const At& at) {
  float sum = kernel.weight[0] * (at(0) + at(kernel.taps - 1));
  for (int t = 1; t < kernel.taps / 2; ++t) sum = sum + kernel.weight[static_cast<std::size_t>(t)] * (at(t) + at(kernel.taps - 1 - t));
  return sum;
}

using Taps = std::array<float, pyramid::kMaxTaps>;

// One value under a kernel, from values that are multiplied by their weights: the rule of
// builder/pyramid/reduce_rows.h.
inline float filtered(const pyramid::HalvingKernel& kernel, const Taps& values, const Taps& weights) {
  const auto taps = static_cast<std::size_t>(kernel.taps);
  if (std::all_of(weights.begin(), weights.begin() + kernel.taps, [](float w) { return w == 1.0F; }))
    return weighted_pairs(kernel, [&](int t) { return values[static_cast<std::size_t>(t)]; });
  const std::size_t first = taps / 2 - 1;
  const std::size_t second = taps / 2;
  const auto share = [](float part, float whole) { return whole > 0.0F ? part / whole : 0.0F; };
  Taps factor{};
  factor[first] = factor[second] = 0.5F;
  for (std::size_t t = 0; t < taps; ++t) {
    if (t == first || t == second) continue;
    const std::size_t partner = (t + first) % 2 == 0 ? second : first;
    const float both = std::min(weights[t], weights[partner]);
    factor[t] = kernel.weight[t] * share(both, weights[t]);
    factor[partner] -= kernel.weight[t] * share(both, weights[partner]);
  }
  float sum = factor[first] * values[first] + factor[second] * values[second];
  for (std::size_t t = 0; t < taps; ++t)
    if (t != first && t != second) sum += factor[t] * values[t];
  return sum;
}

// A row or column that is found by mirroring at the edges.
inline std::int64_t mirrored(std::int64_t at, std::int64_t begin, std::int64_t end) {
  while (at < begin || at >= end) at = at < begin ? 2 * begin - 1 - at : 2 * end - 1 - at;
  return at;
}

inline WholeImage halve_whole(const WholeImage& fine, const pyramid::HalvingKernel& kernel, const PlaneRules& rules) {
  WholeImage coarse(fine.layer, fine.depth + 1, fine.planes);
  const TexelRect& data = fine.data;
  const int w = rules.weight_plane;
  const auto first = static_cast<std::size_t>(kernel.reach());
  const auto column = [&](std::int64_t x) { return fine.layer.is_closed ? x : mirrored(x, data.x, data.right()); };
  const auto row = [&](std::int64_t y) { return mirrored(y, data.y, data.bottom()); };
  // Rows are added up first, then columns; a sum of weights is always the mean of the two in the middle.
  const auto wide = [&](std::int64_t x, std::int64_t y, int p) {
    Taps sums{};
    Taps sums_of_weights{};
    for (int tx = 0; tx < kernel.taps; ++tx) {
      Taps values{};
      Taps weights{};
      const std::int64_t fx = column(2 * x - kernel.reach() + tx);
      for (int ty = 0; ty < kernel.taps; ++ty) {
        const std::int64_t fy = row(2 * y - kernel.reach() + ty);
        values[static_cast<std::size_t>(ty)] = fine.seen(fx, fy, p, rules);
        weights[static_cast<std::size_t>(ty)] = fine.seen(fx, fy, w, rules);
      }
      sums[static_cast<std::size_t>(tx)] = filtered(kernel, values, weights);
      sums_of_weights[static_cast<std::size_t>(tx)] = 0.5F * (weights[first] + weights[first + 1]);
    }
    return p == w ? 0.5F * (sums_of_weights[first] + sums_of_weights[first + 1]) : filtered(kernel, sums, sums_of_weights);
  };
  const auto of_four = [&](std::int64_t x, std::int64_t y, int p, const auto& pick) {
    const auto at = [&](int dx, int dy) { return fine.seen(2 * x + dx, 2 * y + dy, p, rules); };
    return pick(pick(at(0, 0), at(0, 1)), pick(at(1, 0), at(1, 1)));
  };
  // What the box's mean of plane p - 1 and its remainder is beyond the float that plane p - 1 has become.
  const auto remainder = [&](std::int64_t x, std::int64_t y, int p, float halved) {
    const auto four = [&](int q) {
      const auto at = [&](int dx, int dy) { return static_cast<double>(fine.seen(2 * x + dx, 2 * y + dy, q, rules)); };
      return (at(0, 0) + at(1, 0)) + (at(0, 1) + at(1, 1));
    };
    return static_cast<float>((0.25 * four(p - 1) - static_cast<double>(halved)) + 0.25 * four(p));
  };
  // Between the least and the greatest value with data of the 4 x 4 texels around.
  const auto limited = [&](std::int64_t x, std::int64_t y, int p, float value, float weight) {
    float least = std::numeric_limits<float>::infinity();
    float greatest = -least;
    for (std::int64_t fy = 2 * y - 1; fy <= 2 * y + 2; ++fy)
      for (std::int64_t fx = 2 * x - 1; fx <= 2 * x + 2; ++fx)
        if (const float there = fine.seen(fx, fy, w, rules); there > 0.0F) {
          const float here = fine.seen(fx, fy, p, rules);
          const float v = there == 1.0F ? here : here / there;
          least = std::min(least, v);
          greatest = std::max(greatest, v);
        }
    if (weight <= 0.0F) return value;
    const float straight = weight == 1.0F ? value : value / weight;
    const float inside = std::clamp(straight, least, greatest);
    return inside == straight ? value : inside * weight;
  };
  const auto half_of_both = [](float a, float b) { return 0.5F * (a + b); };
  for (std::int64_t y = coarse.data.y; y < coarse.data.bottom(); ++y)
    for (std::int64_t x = coarse.data.x; x < coarse.data.right(); ++x)
      for (int p = 0; p < fine.planes; ++p) {
        float& out = coarse.at(x, y, p);
        if (rules[p] == channels::PlaneRule::kLeast) {
          out = of_four(x, y, p, [](float a, float b) { return std::min(a, b); });
        } else if (rules[p] == channels::PlaneRule::kGreatest) {
          out = of_four(x, y, p, [](float a, float b) { return std::max(a, b); });
        } else if (kernel.is_point) {
          out = fine.seen(2 * x, 2 * y, p, rules);
        } else if (rules[p] == channels::PlaneRule::kRemainder) {
          out = remainder(x, y, p, coarse.at(x, y, p - 1));
        } else if (kernel.taps == 2) {
          out = of_four(x, y, p, half_of_both);
        } else {
          out = wide(x, y, p);
          if (kernel.limits_ringing && p != w) out = limited(x, y, p, out, wide(x, y, w));
          // The inner half of a texel that the edge cuts.
          if (!fine.layer.is_closed && (2 * x < data.x || 2 * x + 1 >= data.right())) out *= 0.5F;
          if (2 * y < data.y || 2 * y + 1 >= data.bottom()) out *= 0.5F;
        }
      }
  return coarse;
}
// What is stored of a level whose first plane holds values at centres: those of texels that the east or south
// edge cuts are continued from the texel before, along the rows first, see builder/pyramid/edge_centres.h.
inline WholeImage at_centres(WholeImage image, const channels::CentreRange& range, const PlaneRules& rules) {
  const int weight_plane = rules.weight_plane;
  const bool is_wide = rules[1] == channels::PlaneRule::kRemainder;
  const TexelRect& data = image.data;
  const auto at = [&](std::int64_t x, std::int64_t y) { return static_cast<std::size_t>((y - data.y) * data.width + (x - data.x)); };
  std::vector<double> heights(static_cast<std::size_t>(data.width * data.height));
  for (std::int64_t y = data.y; y < data.bottom(); ++y)
    for (std::int64_t x = data.x; x < data.right(); ++x)
      if (const double weight = image.get(x, y, weight_plane); weight > 0.0)
        heights[at(x, y)] = (static_cast<double>(image.get(x, y, 0)) + (is_wide ? static_cast<double>(image.get(x, y, 1)) : 0.0)) / weight;
  const auto move = [&](std::int64_t x, std::int64_t y, std::int64_t before_x, std::int64_t before_y, double filled) {
    const double weight = image.get(x, y, weight_plane);
    if (weight <= 0.0 || image.get(before_x, before_y, weight_plane) <= 0.0F) return;
    double& last = heights[at(x, y)];
    const double value = last + (last - heights[at(before_x, before_y)]) * ((1.0 - filled) / (1.0 + filled));
    last = std::clamp(value, std::min(range.least, last), std::max(range.greatest, last));
    image.at(x, y, 0) = static_cast<float>(last * weight);
    if (is_wide) image.at(x, y, 1) = static_cast<float>(last * weight - static_cast<double>(image.at(x, y, 0)));
  };
  const double column = image.layer.filled_column(image.depth);
  const double row = image.layer.filled_row(image.depth);
  for (std::int64_t y = data.y; column < 1.0 && data.width > 1 && y < data.bottom(); ++y)
    move(data.right() - 1, y, data.right() - 2, y, column);
  for (std::int64_t x = data.x; row < 1.0 && data.height > 1 && x < data.right(); ++x)
    move(x, data.bottom() - 1, x, data.bottom() - 2, row);
  return image;
}

inline WholeImage halve_whole(const WholeImage& fine, const pyramid::HalvingKernel& kernel) {
  return halve_whole(fine, kernel, PlaneRules::linear(fine.planes));
}

}  // namespace vt::test
