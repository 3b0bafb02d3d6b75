// A rectangle of a layer in filter space while sources are laid over each other in it. Private to this room.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "store/tile_id.h"

namespace vt::resample {

// Planes of one row follow each other, then those of the next row.
struct PlaneBlock {
  TexelRect rect;
  int planes = 0;
  std::vector<float> floats;

  // Texels of `row` (of the layer), from column `x` on.
  [[nodiscard]] channels::PlaneRow row_at(std::int64_t x, std::int64_t row) {
    channels::PlaneRow out{};
    for (int p = 0; p < planes; ++p)
      out[static_cast<std::size_t>(p)] = floats.data() + ((row - rect.y) * planes + p) * rect.width + (x - rect.x);
    return out;
  }
};

// Premultiplied "over": where the upper one has full weight nothing of the lower one remains.
void composite_row(const channels::PlaneRow& upper, int planes, std::int64_t count, const channels::PlaneRow& lower);

}  // namespace vt::resample
