// Lines through texels for one block, without vectors: the plain definition of
// builder/encode/bptc/bptc_lanes-inl.h, in the same order of operations, because floats are held bit for bit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "store/texel/bptc_table.h"

namespace vt::encode::definition {

template <std::size_t n>
using Color = std::array<float, n>;
template <std::size_t n>
using Texels = std::array<Color<n>, 16>;
template <std::size_t n>
struct Line {
  Color<n> end0{}, end1{};
};
constexpr std::uint32_t kWholeBlock = 0xFFFF;  // subsets are masks: bit i for texel i
inline bool has(std::uint32_t subset, std::size_t texel) { return (subset >> texel & 1U) != 0; }

template <std::size_t n>
float dot(const Color<n>& p, const Color<n>& q) {
  float sum = p[0] * q[0];
  for (std::size_t c = 1; c < n; ++c) sum += p[c] * q[c];
  return sum;
}

template <std::size_t n>
struct Moments {
  float count = 0;
  Color<n> sum{}, mean{};
  std::array<Color<n>, n> rows{};

  Moments(const Texels<n>& texels, std::uint32_t subset) {
    for (std::size_t i = 0; i < 16; ++i) {
      if (!has(subset, i)) continue;
      count += 1;
      for (std::size_t c = 0; c < n; ++c) sum[c] += texels[i][c];
    }
    for (std::size_t c = 0; c < n; ++c) mean[c] = sum[c] / count;
    for (std::size_t i = 0; i < 16; ++i)
      for (std::size_t c = 0; c < n; ++c)
        for (std::size_t d = 0; has(subset, i) && d < n; ++d) rows[c][d] += (texels[i][c] - mean[c]) * (texels[i][d] - mean[d]);
  }
};

template <std::size_t n>
Color<n> principal_axis(const std::array<Color<n>, n>& rows, int iterations) {
  float trace = 0;
  std::size_t largest = 0;
  for (std::size_t c = 0; c < n; ++c) {
    trace += rows[c][c];
    if (rows[c][c] > rows[largest][largest]) largest = c;
  }
  const float scale = 1.0F / std::max(trace, 1e-3F);
  std::array<Color<n>, n> scaled = rows;
  for (Color<n>& row : scaled)
    for (float& value : row) value *= scale;
  Color<n> axis = scaled[largest];
  for (int i = 0; i < iterations; ++i) {
    Color<n> next{};
    for (std::size_t c = 0; c < n; ++c) next[c] = dot(scaled[c], axis);
    axis = next;
  }
  return axis;
}

template <std::size_t n>
Line<n> extremes(const Texels<n>& texels, std::uint32_t subset, const Moments<n>& m) {
  const Color<n> axis = principal_axis(m.rows, 4);
  float low = 0, high = 0;
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(subset, i)) continue;
    Color<n> d = texels[i];
    for (std::size_t c = 0; c < n; ++c) d[c] -= m.mean[c];
    low = std::min(low, dot(d, axis));
    high = std::max(high, dot(d, axis));
  }
  const float length2 = dot(axis, axis);
  const float scale = length2 > 0 ? 1.0F / length2 : 0.0F;
  low *= scale;
  high *= scale;
  Line<n> line;
  for (std::size_t c = 0; c < n; ++c) {
    line.end0[c] = m.mean[c] + axis[c] * low;
    line.end1[c] = m.mean[c] + axis[c] * high;
  }
  return line;
}

// Index of the nearest of the equally spaced positions on a line.
template <std::size_t n>
struct Projection {
  Color<n> direction{};
  float offset, last;
  Projection(const Line<n>& line, unsigned index_bits) : last(static_cast<float>((1U << index_bits) - 1U)) {
    for (std::size_t c = 0; c < n; ++c) direction[c] = line.end1[c] - line.end0[c];
    const float length2 = dot(direction, direction);
    const float scale = length2 > 0 ? last / length2 : 0.0F;
    for (float& value : direction) value *= scale;
    offset = 0.0F - dot(line.end0, direction);
  }
  std::uint32_t index(const Color<n>& texel) const {
    return static_cast<std::uint32_t>(std::nearbyint(std::clamp(dot(texel, direction) + offset, 0.0F, last)));
  }
};

template <std::size_t n>
struct Solution {
  Line<n> line;
  float a = 0, b = 0, c = 0;  // of the quadratic form that is the error
};

template <std::size_t n>
Solution<n> refined(const Line<n>& line, unsigned index_bits, const Texels<n>& texels, std::uint32_t subset, const Moments<n>& m) {
  const Projection<n> projection(line, index_bits);
  float a = 0, b = 0, c = 0;  // integers, exact in any order
  Color<n> x1{};
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(subset, i)) continue;
    const auto w = static_cast<float>(store::bptc_weight(index_bits, projection.index(texels[i])));
    a += (64 - w) * (64 - w), b += (64 - w) * w, c += w * w;
    for (std::size_t k = 0; k < n; ++k) x1[k] += texels[i][k] * w;
  }
  const float determinant = a * c - b * b;
  Solution<n> solution{.line = {m.mean, m.mean}, .a = a, .b = b, .c = c};
  if (!(determinant > 0)) return solution;
  const float scale = 64.0F / determinant;
  for (std::size_t k = 0; k < n; ++k) {
    const float x0 = m.sum[k] * 64.0F - x1[k];
    solution.line.end0[k] = (c * x0 - b * x1[k]) * scale;
    solution.line.end1[k] = (a * x1[k] - b * x0) * scale;
  }
  return solution;
}

}  // namespace vt::encode::definition
