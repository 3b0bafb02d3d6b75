// Opens a store, prints its layers and reads the north-west corner of each, as a first program with vt::store
// would.
#include <cstddef>
#include <cstdio>
#include <vector>

#include "store/mapping_guard.h"
#include "store/region.h"
#include "store/store_reader.h"

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  vt::store::guard_mappings();
  const auto reader = vt::store::StoreReader::open(argv[1]);
  if (!reader) {
    std::fprintf(stderr, "%s\n", reader.error().message.c_str());
    return 2;
  }
  for (const vt::LayerInfo& layer : reader->layers()) {
    if (layer.role != vt::LayerRole::kTexture || layer.holds_blobs()) continue;
    const vt::TexelRect corner{layer.data.x & ~3, layer.data.y & ~3, 4, 4};  // one block, where texels lie in blocks
    std::vector<std::byte> texels(vt::payload_bytes(vt::format_info(layer.format), 4, 4));
    const auto report = vt::store::read_region(*reader, layer.id, layer.finest, corner, texels);
    if (!report) {
      std::fprintf(stderr, "%s\n", report.error().message.c_str());
      return 3;
    }
    std::printf("%s: %lld x %lld texels, first byte %d\n", layer.name.c_str(), static_cast<long long>(layer.data.width),
                static_cast<long long>(layer.data.height), std::to_integer<int>(texels[0]));
  }
}
