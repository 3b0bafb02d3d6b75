// Any bytes as a store: opening, validating, reading every tile it admits to, and a region. Run it as
//   store_fuzz -max_len=32768 -timeout=10 CORPUS tests/golden
// Checksums would turn away nearly everything that is mutated, so every input is tried as it is and once more
// with them made right.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "store/format/layout.h"
#include "store/region.h"
#include "store/store_reader.h"
#include "store/validate.h"
#include "tests/store/reseal.h"

namespace {

using namespace vt;
using namespace vt::store;

// So that an input with a huge tile does not only test the allocator.
constexpr std::size_t kMaxTileBytes = std::size_t{1} << 20;
constexpr std::uint32_t kMaxSide = 64;

void use(std::span<const std::byte> bytes) {
  static const int fd = memfd_create("store", 0);
  if (ftruncate(fd, 0) != 0 || pwrite(fd, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(fd);

  const auto report = validate(path, {.decode_tiles = bytes.size() < 65536});
  if (!report) std::abort();  // whatever the bytes, the file can be read
  const auto reader = StoreReader::open(path);
  // A valid store opens; one that does not open is not valid.
  if (!reader && report->ok()) std::abort();
  if (!reader) return;
  for (const LayerInfo& layer : reader->layers()) {
    if (layer.tile_payload_bytes() > kMaxTileBytes) continue;
    std::vector<std::byte> out(layer.tile_payload_bytes());
    const auto read = [&](TileId tile) {
      return layer.holds_blobs() ? reader->read_blob(layer.id, tile, out) : reader->read(layer.id, tile, out);
    };
    for (int level = 0; level <= layer.finest.value; ++level) {
      const std::uint32_t side = std::min(kMaxSide, std::uint32_t{1} << level);
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          const TileId tile{Level{static_cast<std::uint8_t>(level)}, x, y};
          const auto lookup = reader->lookup(layer.id, tile);
          if (!lookup || lookup->kind == TileKind::kAbsent) continue;
          // In a valid store every tile that is there can be read.
          if (!read(tile) && report->ok()) std::abort();
        }
      }
    }
    std::vector<std::byte> region(payload_bytes(format_info(layer.format), 16, 12));
    static_cast<void>(read_region(*reader, layer.id, layer.finest, {-4, -8, 16, 12}, region));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
  use(bytes);
  std::vector<std::byte> sealed(bytes.begin(), bytes.end());
  vt::store::test::reseal(sealed);
  use(sealed);
  return 0;
}
