// libFuzzer: any bytes as a TIFF. Opens it, reads and hashes a window of at most 256 x 256 samples; must
// neither crash nor hang nor take much memory. Good seeds are the small files of a GeoTIFF collection.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace vt::source;
  const bool is_tiff = size > 4 && (data[0] == 'I' || data[0] == 'M') && data[0] == data[1];
  if (!is_tiff) return 0;  // other pictures are OpenImageIO's affair
  // The reader wants a path; a file in memory has one.
  const int file = ::memfd_create("fuzz", 0);
  if (file < 0) return 0;
  if (::write(file, data, size) == static_cast<ssize_t>(size)) {
    const auto source = open_raster("/proc/self/fd/" + std::to_string(file));
    if (source) {
      const RasterInfo& info = (*source)->info();
      const std::int64_t width = std::min<std::int64_t>(info.width, 256);
      const std::int64_t height = std::min<std::int64_t>(info.height, 256);
      std::vector<int> bands;
      for (int band = 0; band < std::min(info.bands, 8); ++band) bands.push_back(band);
      const std::size_t pitch = static_cast<std::size_t>(width) * bands.size() * sample_bytes(info.sample_type);
      std::vector<std::byte> out(pitch * static_cast<std::size_t>(height));
      const Window window{info.width - width, info.height - height, width, height};
      vt::store::ContentHasher while_reading;
      vt::store::ContentHasher hashed;
      const bool was_read = (*source)->read(window, bands, out, pitch, &while_reading).has_value();
      const bool was_hashed = (*source)->hash(window, bands, hashed).has_value();
      if (was_read && (!was_hashed || while_reading.digest() != hashed.digest())) __builtin_trap();
    }
  }
  ::close(file);
  return 0;
}
