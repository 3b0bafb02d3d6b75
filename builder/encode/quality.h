// How much work a block encoder may spend. Every level gives the same bytes on every CPU; a higher one takes longer and keeps a smaller
// squared error over an image, up to what the encoder's own header promises.
#pragma once

#include <cstdint>

namespace vt::encode {

enum class Quality : std::uint8_t {
  kFast,    // one pass: end points straight from the extremes of the block; for previews
  kNormal,  // refined by least squares; the default of every build
  kBest,    // a search over end points that only data made once and read often is worth
};

}  // namespace vt::encode
