#include "builder/pyramid/make_cascade.h"

#include "builder/pyramid/class_cascade.h"
#include "builder/pyramid/plane_cascade.h"

namespace vt::pyramid {

std::unique_ptr<Cascade> make_cascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs,
                                      const channels::ChannelCodec& codec, const HalvingKernel& kernel, int tile_exponent,
                                      int area_exponent) {
  if (codec.class_counting())
    return std::make_unique<ClassCascade>(std::move(levels), layer, outputs, *codec.class_counting(), tile_exponent, area_exponent);
  const PlaneMeaning planes{codec.rules(), codec.weight_plane(), codec.centre_range()};
  return std::make_unique<PlaneCascade>(std::move(levels), layer, outputs, planes, kernel, tile_exponent);
}

}  // namespace vt::pyramid
