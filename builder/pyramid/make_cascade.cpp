#include "builder/pyramid/make_cascade.h"

#include "builder/pyramid/class_cascade.h"
#include "builder/pyramid/plane_cascade.h"

namespace vt::pyramid {

std::unique_ptr<Cascade> make_cascade(std::vector<BlockLevel> levels, int outputs, const channels::ChannelCodec& codec,
                                      const HalvingKernel& kernel, int depth, int tile_exponent) {
  if (codec.class_counting())
    return std::make_unique<ClassCascade>(std::move(levels), outputs, *codec.class_counting(), depth, tile_exponent);
  return std::make_unique<PlaneCascade>(std::move(levels), outputs, codec.rules(), codec.weight_plane(), kernel, tile_exponent);
}

}  // namespace vt::pyramid
