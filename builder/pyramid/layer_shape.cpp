#include "builder/pyramid/layer_shape.h"

#include <algorithm>
#include <cmath>

namespace vt::pyramid {
namespace {

// The remainder that is never negative.
std::int64_t modulo(std::int64_t value, std::int64_t divisor) {
  const std::int64_t rest = value % divisor;
  return rest < 0 ? rest + divisor : rest;
}

}  // namespace

// Places count in texels of the finest level, so that they are whole numbers.
SeamColumn LayerShape::column_past_edge(int depth, std::int64_t column) const {
  constexpr double kSteps = 1 << 20;
  const std::int64_t texel = std::int64_t{1} << depth;
  const std::int64_t last = data_at(depth).width - 1;
  const std::int64_t at = modulo(column * texel, data.width);
  const auto share_of = [&](std::int64_t part, std::int64_t whole) {
    return static_cast<float>(std::round(static_cast<double>(part) / static_cast<double>(whole) * kSteps) / kSteps);
  };
  // From the last column to the first it is less than a texel, unless the level wraps.
  if (at > last * texel) return {last, 0, share_of(at - last * texel, data.width - last * texel)};
  const std::int64_t first = at / texel;
  return {first, std::min(first + 1, last), share_of(at % texel, texel)};
}

double LayerShape::filled(std::int64_t end, int depth) {
  const std::int64_t texel = std::int64_t{1} << depth;
  const std::int64_t rest = modulo(end, texel);
  return rest == 0 ? 1.0 : static_cast<double>(rest) / static_cast<double>(texel);
}

std::vector<WrappedPart> wrapped_parts(const TexelRect& rect, const TexelRect& data) {
  std::vector<WrappedPart> parts;
  for (std::int64_t x = rect.x; x < rect.right();) {
    const std::int64_t inside = data.x + modulo(x - data.x, data.width);
    const std::int64_t width = std::min(data.right() - inside, rect.right() - x);
    parts.push_back({{inside, rect.y, width, rect.height}, x - rect.x});
    x += width;
  }
  return parts;
}

}  // namespace vt::pyramid
