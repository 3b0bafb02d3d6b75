// The definition of an overview, whole level at once and texel by texel: short enough that reading it is checking it. What the builder
// makes block by block with SIMD rows must equal this bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

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

inline WholeImage halve_whole(const WholeImage& fine, const pyramid::HalvingKernel& kernel) {
  WholeImage coarse(coarser(fine.data, 1), fine.planes);
  const int weight_plane = fine.planes - 1;
  const auto filtered = [&](std::int64_t x, std::int64_t y, int p) {
    return weighted_pairs(kernel, [&](int tx) {
      return weighted_pairs(kernel, [&](int ty) { return fine.get(2 * x - kernel.reach() + tx, 2 * y - kernel.reach() + ty, p); });
    });
  };
  const auto box = [&](std::int64_t x, std::int64_t y, int p) {
    return 0.25F * ((fine.get(2 * x, 2 * y, p) + fine.get(2 * x + 1, 2 * y, p)) +
                    (fine.get(2 * x, 2 * y + 1, p) + fine.get(2 * x + 1, 2 * y + 1, p)));
  };
  for (std::int64_t y = coarse.data.y; y < coarse.data.bottom(); ++y)
    for (std::int64_t x = coarse.data.x; x < coarse.data.right(); ++x) {
      const float weight = filtered(x, y, weight_plane);
      const float box_weight = box(x, y, weight_plane);
      for (int p = 0; p < fine.planes; ++p) {
        float& out = coarse.at(x, y, p);
        if (box_weight <= 0.0F)
          out = 0.0F;  // data never grow
        else if (!(weight >= 0.5F * box_weight))
          out = box(x, y, p);  // the lobes left too little to divide by
        else if (weight > 1.0F)
          out = p == weight_plane ? 1.0F : filtered(x, y, p) / weight;
        else
          out = filtered(x, y, p);
      }
    }
  return coarse;
}

}  // namespace vt::test
