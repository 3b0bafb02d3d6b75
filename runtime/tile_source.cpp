#include "runtime/tile_source.h"

#include "store/region.h"

namespace vt::runtime {

Result<void> StoreTileSource::read(Level level, const TexelRect& rect, std::span<std::byte> out) {
  VT_CHECK(store::read_region(*reader_, layer_, level, rect, out));
  return {};
}

}  // namespace vt::runtime
