#include "tests/encode/bc1/bc1_definition.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace vt::encode {
namespace {

using Color = std::array<float, 3>;

constexpr std::array<int, 3> kBits{5, 6, 5};

int expanded(int code, int bits) { return bits == 5 ? code * 8 + code / 4 : code * 4 + code / 16; }
float dot(const Color& p, const Color& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }

struct Line {
  Color end0, end1;
};

// Position 0..3 on the line from end0 to end1.
struct Projection {
  Color direction;
  float offset;
  explicit Projection(const Line& line) {
    const Color along{line.end1[0] - line.end0[0], line.end1[1] - line.end0[1], line.end1[2] - line.end0[2]};
    const float length2 = dot(along, along);
    const float scale = length2 > 0 ? 3.0F / length2 : 0.0F;
    direction = {along[0] * scale, along[1] * scale, along[2] * scale};
    offset = 0.5F - dot(line.end0, direction);
  }
  int position(const Color& texel) const { return static_cast<int>(std::clamp(dot(texel, direction) + offset, 0.0F, 3.0F)); }
};

struct Candidate {
  Line line;
  std::array<int, 3> code0, code1;
  float error;
};

struct Block {
  Color mean, sum;
  std::array<Color, 16> texels;  // less the mean

  explicit Block(const BlockTexels& values) : mean{}, sum{}, texels{} {
    for (std::size_t c = 0; c < 3; ++c) {
      int total = 0;
      for (const auto& texel : values) total += texel[c];
      const int rounded = (total + 8) / 16;
      mean[c] = static_cast<float>(rounded);
      sum[c] = static_cast<float>(total - 16 * rounded);
      for (std::size_t i = 0; i < 16; ++i) texels[i][c] = static_cast<float>(values[i][c] - rounded);
    }
  }

  float moment(std::size_t c, std::size_t d) const {
    float total = 0;
    for (const Color& texel : texels) total += texel[c] * texel[d];
    return total;
  }

  Color principal_axis() const {
    std::array<Color, 3> covariance{};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t d = 0; d < 3; ++d) covariance[c][d] = moment(c, d) * 16.0F - sum[c] * sum[d];
    const Color diagonal{covariance[0][0], covariance[1][1], covariance[2][2]};
    const float scale = 1.0F / std::max(diagonal[0] + diagonal[1] + diagonal[2], 1.0F);
    for (Color& row : covariance)
      for (float& value : row) value *= scale;
    std::size_t first = diagonal[1] > diagonal[0] ? 1 : 0;
    if (diagonal[2] > std::max(diagonal[0], diagonal[1])) first = 2;
    Color axis = covariance[first];
    for (int i = 0; i < 4; ++i) axis = {dot(covariance[0], axis), dot(covariance[1], axis), dot(covariance[2], axis)};
    return axis;
  }

  Line extremes(const Color& axis) const {
    float low = 1e30F, high = -1e30F;
    for (const Color& texel : texels) {
      low = std::min(low, dot(texel, axis));
      high = std::max(high, dot(texel, axis));
    }
    const Color centre{sum[0] / 16.0F, sum[1] / 16.0F, sum[2] / 16.0F};
    const float length2 = dot(axis, axis);
    const float scale = length2 > 0 ? 1.0F / length2 : 0.0F;
    const float to_low = (low - dot(centre, axis)) * scale, to_high = (high - dot(centre, axis)) * scale;
    Line line{};
    for (std::size_t c = 0; c < 3; ++c) {
      line.end0[c] = centre[c] + axis[c] * to_low;
      line.end1[c] = centre[c] + axis[c] * to_high;
    }
    return line;
  }

  Candidate refined(const Line& start) const {
    const Projection projection(start);
    float a = 0, b = 0, c = 0;
    Color x0{}, x1{};
    for (const Color& texel : texels) {
      const auto w = static_cast<float>(projection.position(texel));
      a += (3 - w) * (3 - w), b += (3 - w) * w, c += w * w;
      for (std::size_t k = 0; k < 3; ++k) x0[k] += (3 - w) * texel[k], x1[k] += w * texel[k];
    }
    const float determinant = a * c - b * b;
    const float scale = determinant > 0 ? 3.0F / determinant : 0.0F;
    Candidate best{};
    std::array<float, 3> errors{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto top = static_cast<float>((1 << kBits[k]) - 1);
      const float steps = top / 255.0F;
      const float end0 = (c * x0[k] - b * x1[k]) * scale + mean[k];
      const float end1 = (a * x1[k] - b * x0[k]) * scale + mean[k];
      const int low0 = static_cast<int>(std::clamp(end0 * steps, 0.0F, top - 1));
      const int low1 = static_cast<int>(std::clamp(end1 * steps, 0.0F, top - 1));
      errors[k] = 1e30F;
      for (const int code0 : {low0, low0 + 1}) {
        for (const int code1 : {low1, low1 + 1}) {
          const float e0 = static_cast<float>(expanded(code0, kBits[k])) - mean[k];
          const float e1 = static_cast<float>(expanded(code1, kBits[k])) - mean[k];
          const float error = e0 * (a * e0 - 6.0F * x0[k]) + (e1 * (c * e1 - 6.0F * x1[k]) + (b + b) * e0 * e1);
          if (error >= errors[k]) continue;
          errors[k] = error;
          best.code0[k] = code0, best.code1[k] = code1;
          best.line.end0[k] = e0, best.line.end1[k] = e1;
        }
      }
    }
    best.error = errors[0] + errors[1] + errors[2];
    return best;
  }
};

// The pair of codes whose 2:1 mixture is nearest, the closer pair first: a search over all.
std::pair<int, int> single_color(int value, int bits) {
  std::pair<int, int> best{};
  int best_error = 1000, best_spread = 1000, best_value = 1000;
  for (int code0 = 0; code0 < 1 << bits; ++code0) {
    for (int code1 = 0; code1 < 1 << bits; ++code1) {
      const int a = expanded(code0, bits), b = expanded(code1, bits);
      const int mixed = (2 * a + b + 1) / 3;
      const int error = std::abs(mixed - value), spread = std::abs(a - b);
      if (std::tuple(error, mixed, spread) < std::tuple(best_error, best_value, best_spread)) {
        best_error = error, best_value = mixed, best_spread = spread;
        best = {code0, code1};
      }
    }
  }
  return best;
}

}  // namespace

std::array<std::byte, 8> encode_block_by_definition(const BlockTexels& values) {
  const Block block(values);
  const Line whole = block.extremes(block.principal_axis());
  const auto inset = [&](float at0, float at1) {
    Line line = whole;
    for (std::size_t c = 0; c < 3; ++c) {
      const float along = whole.end1[c] - whole.end0[c];
      line.end0[c] += along * at0;
      line.end1[c] -= along * at1;
    }
    return line;
  };
  Candidate best = block.refined(inset(0.05F, 0.05F));
  const auto compete = [&](const Candidate& other) {
    if (other.error < best.error) best = other;
  };
  compete(block.refined(best.line));
  compete(block.refined(inset(0.25F, 0.0F)));
  compete(block.refined(inset(0.0F, 0.25F)));
  compete(block.refined(best.line));

  // One colour for all texels, when that is no worse.
  float single_error = 0, spread = 0;
  std::array<int, 3> single0{}, single1{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto [code0, code1] = single_color(static_cast<int>(block.mean[c]), kBits[c]);
    single0[c] = code0, single1[c] = code1;
    const int value = (2 * expanded(code0, kBits[c]) + expanded(code1, kBits[c]) + 1) / 3;
    const float d = static_cast<float>(value) - block.mean[c];
    single_error += (d * 16.0F - 2.0F * block.sum[c]) * d;
    spread += block.moment(c, c);
  }
  std::array<int, 16> positions{};
  if (single_error * 9.0F <= best.error || spread == 0) {
    best.code0 = single0, best.code1 = single1;
    positions.fill(1);
  } else {
    const Projection projection(best.line);
    for (std::size_t i = 0; i < 16; ++i) positions[i] = projection.position(block.texels[i]);
  }

  int color0 = best.code0[0] << 11 | best.code0[1] << 5 | best.code0[2];
  int color1 = best.code1[0] << 11 | best.code1[1] << 5 | best.code1[2];
  if (color0 < color1) {
    std::swap(color0, color1);
    for (int& w : positions) w = 3 - w;
  }
  if (color0 == color1) {
    positions.fill(color0 == 0 ? 3 : 0);
    color0 == 0 ? ++color0 : --color1;
  }
  constexpr std::array<std::uint32_t, 4> kIndexOfPosition{0, 2, 3, 1};
  std::uint32_t indices = 0;
  for (std::size_t i = 0; i < 16; ++i) indices |= kIndexOfPosition[static_cast<std::size_t>(positions[i])] << (2 * i);
  const std::uint64_t bits = static_cast<std::uint64_t>(color0) | static_cast<std::uint64_t>(color1) << 16U | std::uint64_t{indices} << 32U;
  std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::byte>(bits >> (8 * i));
  return bytes;
}

int plain_least_squares_error(const BlockTexels& values) {
  const Block block(values);
  const Line start = block.extremes(block.principal_axis());
  std::array<std::array<double, 3>, 2> ends{};
  for (std::size_t c = 0; c < 3; ++c) ends[0][c] = start.end0[c] + block.mean[c], ends[1][c] = start.end1[c] + block.mean[c];
  int best = 1 << 30;
  for (int round = 0; round < 8; ++round) {
    std::array<std::array<int, 3>, 4> palette{};
    for (std::size_t c = 0; c < 3; ++c) {
      const int top = (1 << kBits[c]) - 1;
      const auto rounded = [&](double v) { return expanded(std::clamp(static_cast<int>(std::lround(v * top / 255.0)), 0, top), kBits[c]); };
      const int a = rounded(ends[0][c]), b = rounded(ends[1][c]);
      palette[0][c] = a, palette[3][c] = b, palette[1][c] = (2 * a + b + 1) / 3, palette[2][c] = (a + 2 * b + 1) / 3;
    }
    int error = 0;
    double aa = 0, ab = 0, bb = 0;
    std::array<double, 3> ax{}, bx{};
    for (const auto& texel : values) {
      int nearest = 1 << 30;
      std::size_t position = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        int d2 = 0;
        for (std::size_t c = 0; c < 3; ++c) d2 += (texel[c] - palette[k][c]) * (texel[c] - palette[k][c]);
        if (d2 < nearest) nearest = d2, position = k;
      }
      error += nearest;
      const double b = static_cast<double>(position) / 3.0, a = 1.0 - b;
      aa += a * a, ab += a * b, bb += b * b;
      for (std::size_t c = 0; c < 3; ++c) ax[c] += a * texel[c], bx[c] += b * texel[c];
    }
    best = std::min(best, error);
    const double determinant = aa * bb - ab * ab;
    if (determinant < 1e-9) break;
    for (std::size_t c = 0; c < 3; ++c) {
      ends[0][c] = (ax[c] * bb - bx[c] * ab) / determinant;
      ends[1][c] = (bx[c] * aa - ax[c] * ab) / determinant;
    }
  }
  return best;
}

}  // namespace vt::encode
