#include "builder/resample/rows/texel_block.h"

#include <algorithm>
#include <bit>

#include "builder/resample/grid/buffers.h"

namespace vt::resample {
namespace {

using channels::ClassArea;
using channels::PlaneRule;

// What is seen of two texels, as parts of all that one of them covers.
struct Shares {
  float upper = 0.0F;  // times its planes, which hold its transparency
  float lower = 0.0F;
};

Shares shares_of(std::uint64_t upper, std::uint64_t lower, float upper_weight) {
  const auto places = [](std::uint64_t mask) { return static_cast<float>(std::popcount(mask)); };
  const float all = places(upper | lower);
  return {places(upper) / all, (places(lower & ~upper) + places(lower & upper) * (1.0F - upper_weight)) / all};
}

double area_of_all(std::span<const ClassArea> classes) {
  double sum = 0.0;
  for (const ClassArea& one : classes) sum += one.area;
  return sum;
}

void mix_linear(float above, const Shares& shares, float& here) {
  const float part = shares.upper == 1.0F ? above : shares.upper * above;
  here = shares.lower == 0.0F ? part : part + shares.lower * here;
}

}  // namespace

// Bits of the row are those of the column in reverse order (van der Corput 1935).
Point2 place_in_texel(int i) {
  int reversed = 0;
  for (int bit = 0; bit < 6; ++bit) reversed |= ((i >> bit) & 1) << (5 - bit);
  return {(i + 0.5) / kPlaces, (reversed + 0.5) / kPlaces};
}

void clear(TexelBlock& block, const TexelRect& rect, const channels::ChannelCodec& codec, bool has_areas, bool is_mosaic) {
  const auto texels = static_cast<std::size_t>(rect.width * rect.height);
  block.has_areas = has_areas;
  block.block.rect = rect;
  if (has_areas) {
    block.areas.reset(rect);
  } else {
    block.block.planes = codec.planes();
    refit(block.block.floats, texels * static_cast<std::size_t>(codec.planes()));
    for (std::int64_t row = rect.y; row < rect.bottom(); ++row) fill_with_nothing(codec, true, rect.width, block.block.row_at(rect.x, row));
  }
  if (!is_mosaic) return;
  block.places.assign(texels, 0);
  block.has_centre.assign(texels, 0);
}

void lay_over(const TexelBlock& upper, const channels::ChannelCodec& codec, TexelBlock& lower) {
  const TexelRect& rect = upper.block.rect;
  const auto weight_plane = static_cast<std::size_t>(codec.weight_plane());
  const std::vector<float> nothing = planes_of_nothing(codec);
  std::vector<ClassArea> mixed;
  for (std::int64_t y = rect.y; y < rect.bottom(); ++y) {
    const channels::ConstPlaneRow above = upper.has_areas ? channels::ConstPlaneRow{} : upper.block.row_at(rect.x, y);
    const channels::PlaneRow here = upper.has_areas ? channels::PlaneRow{} : lower.block.row_at(rect.x, y);
    for (std::int64_t i = 0; i < rect.width; ++i) {
      const std::size_t from = upper.index_of(rect.x + i, y);
      const std::size_t to = lower.index_of(rect.x + i, y);
      const std::uint64_t places = upper.places[from];
      if (places == 0) continue;
      const std::uint64_t below = lower.places[to];
      const bool had_centre = lower.has_centre[to] != 0;
      lower.places[to] |= places;
      lower.has_centre[to] |= upper.has_centre[from];
      if (upper.has_areas) {
        const std::span<const ClassArea> classes = upper.areas.at(rect.x + i, y);
        const auto weight = static_cast<float>(std::min(1.0, area_of_all(classes)));
        const Shares shares = shares_of(places, below, weight);
        mixed.clear();
        for (const ClassArea& one : classes) channels::add_class_area(mixed, one.id, static_cast<double>(shares.upper) * one.area);
        if (shares.lower > 0.0F)
          for (const ClassArea& one : lower.areas.at(rect.x + i, y))
            channels::add_class_area(mixed, one.id, static_cast<double>(shares.lower) * one.area);
        lower.areas.set(rect.x + i, y, mixed);
        continue;
      }
      const float weight = above[weight_plane][i];
      const Shares seen = shares_of(places, below, weight);
      Shares shares = seen;
      if (codec.is_surface()) {
        if (upper.has_centre[from] == 0)
          shares = {0.0F, 1.0F};
        else
          shares = shares_of(kAllPlaces, had_centre ? kAllPlaces : 0, weight);
      }
      for (std::size_t p = 0; p < codec.rules().size(); ++p) {
        const float value = above[p][i];
        float& result = here[p][i];
        if (is_sum(codec.rules()[p]))
          mix_linear(value, shares, result);
        else if (seen.lower == 0.0F || result == nothing[p])
          result = value;
        else if (value != nothing[p])
          result = codec.rules()[p] == PlaneRule::kLeast ? std::min(value, result) : std::max(value, result);
      }
    }
  }
}

void drop_without_centre(const channels::ChannelCodec& codec, TexelBlock& block) {
  const TexelRect& rect = block.block.rect;
  for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
    for (std::int64_t x = rect.x; x < rect.right(); ++x) {
      const std::size_t texel = block.index_of(x, y);
      if (block.places[texel] == 0 || block.has_centre[texel] != 0) continue;
      if (block.has_areas)
        block.areas.set(x, y, {});
      else
        fill_with_nothing(codec, true, 1, block.block.row_at(x, y));
    }
}

}  // namespace vt::resample
