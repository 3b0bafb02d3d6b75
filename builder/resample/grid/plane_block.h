// A rectangle of texels or samples in filter space while sources are laid over each other in it. Private to
// this folder.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "store/tile_id.h"

namespace vt::resample {

// Planes of one row follow each other, then those of the next row.
struct PlaneBlock {
  TexelRect rect;
  int planes = 0;
  std::vector<float> floats;

  // From column `x` of `row` on, both counted as `rect` is: the first plane; the others follow at distances
  // of rect.width.
  [[nodiscard]] const float* first_plane(std::int64_t x, std::int64_t row) const { return floats.data() + offset_of(x, row, 0); }
  // The same of all planes.
  [[nodiscard]] channels::PlaneRow row_at(std::int64_t x, std::int64_t row) {
    channels::PlaneRow out{};
    for (int p = 0; p < planes; ++p) out[static_cast<std::size_t>(p)] = floats.data() + offset_of(x, row, p);
    return out;
  }
  [[nodiscard]] channels::ConstPlaneRow row_at(std::int64_t x, std::int64_t row) const {
    channels::ConstPlaneRow out{};
    for (int p = 0; p < planes; ++p) out[static_cast<std::size_t>(p)] = floats.data() + offset_of(x, row, p);
    return out;
  }

 private:
  [[nodiscard]] std::int64_t offset_of(std::int64_t x, std::int64_t row, int plane) const {
    return ((row - rect.y) * planes + plane) * rect.width + (x - rect.x);
  }
};

// The planes of `codec` of a row without data; all of them when `derived`, otherwise the source planes.
void fill_with_nothing(const channels::ChannelCodec& codec, bool derived, std::int64_t count, const channels::PlaneRow& out);

// All planes of one texel without data.
[[nodiscard]] std::vector<float> planes_of_nothing(const channels::ChannelCodec& codec);

// Premultiplied "over": where the upper one has full weight nothing of the lower one remains; least and
// greatest values are of all that is seen. `rules` of the planes of both.
void composite_row(const channels::PlaneRow& upper, std::span<const channels::PlaneRule> rules, int weight_plane, std::int64_t count,
                   const channels::PlaneRow& lower);

}  // namespace vt::resample
