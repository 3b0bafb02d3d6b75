// Texels of a layer in filter space while grids of sources are laid over each other in it. Private to this
// folder. Threads: a value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/channels/codec/class_areas.h"
#include "builder/resample/grid/plane_block.h"
#include "store/tile_id.h"
#include "store/vt_mapping.h"

namespace vt::resample {

// Places of a texel that are asked whether they lie in a source, each of them in a column and a row of its
// own of 64 x 64: an edge that runs along the texel's is met to 1/64 texel.
inline constexpr int kPlaces = 64;
inline constexpr std::uint64_t kAllPlaces = ~std::uint64_t{0};
// Where place `i` lies in the texel, 0 to 1 from its north-western corner.
[[nodiscard]] Point2 place_in_texel(int i);

struct TexelBlock {
  PlaneBlock block;                // all planes; texels that lie in no source are without data
  channels::ClassAreaBlock areas;  // instead of them, when has_areas
  bool has_areas = false;
  // For each texel, in mosaics: which of its places lie in a source (its planes are those of the covered part
  // alone), and whether its centre does.
  std::vector<std::uint64_t> places;
  std::vector<std::uint8_t> has_centre;

  [[nodiscard]] std::size_t index_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y - block.rect.y) * block.rect.width + (x - block.rect.x));
  }
};

// A rectangle without data.
void clear(TexelBlock& block, const TexelRect& rect, const channels::ChannelCodec& codec, bool has_areas, bool is_mosaic);

// Lays `upper`, whose rectangle lies in that of `lower`, over it. Each place of a texel shows the upper one,
// where that lies there, and what is below as far as the upper one lets it through. The value of a surface is
// that at the texel's centre, and belongs to the upper one when that lies there; its least and greatest
// values are of all places.
void lay_over(const TexelBlock& upper, const channels::ChannelCodec& codec, TexelBlock& lower);

// Takes the data of texels whose centre lies in no source.
void drop_without_centre(const channels::ChannelCodec& codec, TexelBlock& block);

}  // namespace vt::resample
