// The definition of an overview, whole level at once and texel by texel: short enough that reading it is checking it. What the builder
// makes block by block with SIMD rows must equal this bit for bit.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "builder/pyramid/halving_kernel.h"
#include "store/tile_id.h"

namespace vt::test {

// All planes of one level; zero (no data) outside the data rectangle. The last plane is the weight.
struct WholeImage {
  TexelRect data;
  int planes;
  std::vector<float> floats;

  WholeImage(const TexelRect& rect, int plane_count)
      : data(rect), planes(plane_count), floats(static_cast<std::size_t>(rect.width * rect.height * plane_count), 0.0F) {}

  float& at(std::int64_t x, std::int64_t y, int p) { return floats[index(x, y, p)]; }
  [[nodiscard]] float get(std::int64_t x, std::int64_t y, int p) const { return data.contains(x, y) ? floats[index(x, y, p)] : 0.0F; }

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

inline WholeImage halve_whole(const WholeImage& fine, const pyramid::HalvingKernel& kernel, const PlaneRules& rules) {
  WholeImage coarse(coarser(fine.data, 1), fine.planes);
  const int w = rules.weight_plane;
  const auto get = [&](std::int64_t x, std::int64_t y, int p) { return fine.data.contains(x, y) ? fine.get(x, y, p) : rules.nothing(p); };
  const auto filtered = [&](std::int64_t x, std::int64_t y, int p) {
    return weighted_pairs(kernel, [&](int tx) {
      return weighted_pairs(kernel, [&](int ty) { return fine.get(2 * x - kernel.reach() + tx, 2 * y - kernel.reach() + ty, p); });
    });
  };
  const auto box = [&](std::int64_t x, std::int64_t y, int p) {
    return 0.25F * ((fine.get(2 * x, 2 * y, p) + fine.get(2 * x + 1, 2 * y, p)) +
                    (fine.get(2 * x, 2 * y + 1, p) + fine.get(2 * x + 1, 2 * y + 1, p)));
  };
  const auto of_four = [&](std::int64_t x, std::int64_t y, int p, const auto& pick) {
    return pick(pick(get(2 * x, 2 * y, p), get(2 * x + 1, 2 * y, p)), pick(get(2 * x, 2 * y + 1, p), get(2 * x + 1, 2 * y + 1, p)));
  };
  // Between the least and the greatest value with data of the 4 x 4 texels around.
  const auto limited = [&](std::int64_t x, std::int64_t y, int p, float value, float weight) {
    float least = std::numeric_limits<float>::infinity();
    float greatest = -least;
    for (std::int64_t fy = 2 * y - 1; fy <= 2 * y + 2; ++fy)
      for (std::int64_t fx = 2 * x - 1; fx <= 2 * x + 2; ++fx)
        if (const float there = fine.get(fx, fy, w); there > 0.0F) {
          const float v = there == 1.0F ? fine.get(fx, fy, p) : fine.get(fx, fy, p) / there;
          least = std::min(least, v);
          greatest = std::max(greatest, v);
        }
    if (weight <= 0.0F || !(least <= greatest)) return value;
    const float straight = weight == 1.0F ? value : value / weight;
    const float inside = std::clamp(straight, least, greatest);
    return inside == straight ? value : inside * weight;
  };
  for (std::int64_t y = coarse.data.y; y < coarse.data.bottom(); ++y)
    for (std::int64_t x = coarse.data.x; x < coarse.data.right(); ++x) {
      const float weight = filtered(x, y, w);
      const float box_weight = box(x, y, w);
      for (int p = 0; p < fine.planes; ++p) {
        float& out = coarse.at(x, y, p);
        if (rules[p] == channels::PlaneRule::kLeast)
          out = of_four(x, y, p, [](float a, float b) { return std::min(a, b); });
        else if (rules[p] == channels::PlaneRule::kGreatest)
          out = of_four(x, y, p, [](float a, float b) { return std::max(a, b); });
        else if (kernel.is_point)
          out = get(2 * x, 2 * y, p);
        else if (box_weight <= 0.0F)
          out = 0.0F;  // data never grow
        else if (!(weight >= 0.5F * box_weight))
          out = box(x, y, p);  // the lobes left too little to divide by
        else if (weight > 1.0F)
          out = p == w ? 1.0F : filtered(x, y, p) / weight;
        else
          out = filtered(x, y, p);
      }
      if (kernel.limits_ringing)
        for (int p = 0; p < fine.planes; ++p)
          if (p != w && rules[p] == channels::PlaneRule::kLinear)
            coarse.at(x, y, p) = limited(x, y, p, coarse.at(x, y, p), coarse.at(x, y, w));
    }
  return coarse;
}
inline WholeImage halve_whole(const WholeImage& fine, const pyramid::HalvingKernel& kernel) {
  return halve_whole(fine, kernel, PlaneRules::linear(fine.planes));
}

}  // namespace vt::test
