#include "builder/encode/reference_rows.h"

#include <algorithm>
#include <cassert>

namespace vt::encode {
namespace {

bool is_densely_measured(const LayerInfo& layer, Level level) {
  const TexelRect data = layer.data_rect(level);
  return data.width * data.height <= kDenselyMeasuredTexels;
}

}  // namespace

std::int64_t measured_rows_of_tile(const LayerInfo& layer, Level level) {
  const std::int64_t edge = layer.tile_texels();
  return is_densely_measured(layer, level) ? edge : (edge / 4 + kMeasuredRowOfBlocks - 1) / kMeasuredRowOfBlocks * 4;
}

ReferenceRows::ReferenceRows(const LayerInfo& layer, int planes, Level level, const TexelRect& core)
    : planes_(planes), core_(core), tile_exponent_(layer.tile_exponent), is_dense_(is_densely_measured(layer, level)) {
  if (!core.empty()) floats_.resize(static_cast<std::size_t>(measured_rows_of_tile(layer, level) * planes * core.width));
}

void ReferenceRows::keep(std::int64_t y, const channels::ConstPlaneRow& rows) {
  if (!is_measured(y)) return;
  for (int p = 0; p < planes_; ++p) std::copy_n(rows[static_cast<std::size_t>(p)], core_.width, floats_.data() + offset_of(y, p));
}

bool ReferenceRows::is_measured(std::int64_t y) const {
  return is_dense_ || (y >> 2) % kMeasuredRowOfBlocks == (y >> tile_exponent_) % kMeasuredRowOfBlocks;
}

channels::ConstPlaneRow ReferenceRows::row(std::int64_t y) const {
  assert(is_measured(y));
  channels::ConstPlaneRow rows{};
  for (int p = 0; p < planes_; ++p) rows[static_cast<std::size_t>(p)] = floats_.data() + offset_of(y, p);
  return rows;
}

std::size_t ReferenceRows::offset_of(std::int64_t y, int plane) const {
  const std::int64_t in_tile = y & ((std::int64_t{1} << tile_exponent_) - 1);
  const std::int64_t slot = is_dense_ ? in_tile : (in_tile >> 2) / kMeasuredRowOfBlocks * 4 + (in_tile & 3);
  return static_cast<std::size_t>((slot * planes_ + plane) * core_.width);
}

}  // namespace vt::encode
