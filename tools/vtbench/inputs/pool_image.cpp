#include "tools/vtbench/inputs/pool_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tools/vtbench/measure/machine.h"

namespace vt::bench {
Result<std::uint32_t> pool_tiles(const source::RasterInfo& image) {
  const std::int64_t all = (image.width / kPoolTile) * (image.height / kPoolTile);
  if (image.bands < 3 || image.sample_type != SampleType::kUint8 || all < 3)
    return fail(ErrorCode::kUsage,
                fmt::format("{}: tiles are cut from colour images of 8 bits of at least 720 x 240 samples, this one is "
                            "{} x {} with {} bands of {} bits",
                            image.path.string(), image.width, image.height, image.bands, 8 * sample_bytes(image.sample_type)));
  return static_cast<std::uint32_t>(std::min<std::int64_t>(all, kPoolTiles));
}

Result<void> write_pool_image(const std::filesystem::path& path, const source::RasterSource& image, TiledTiffSpec spec) {
  spec.tile = kPoolTile;
  VT_ASSIGN(const std::uint32_t stored, pool_tiles(image.info()));
  VT_ASSIGN(TiledTiffWriter writer, TiledTiffWriter::create(path, spec));
  const std::int64_t columns = image.info().width / kPoolTile;
  const std::int64_t all = columns * (image.info().height / kPoolTile);
  constexpr std::array kRgb = {0, 1, 2};
  std::vector<std::byte> tile(static_cast<std::size_t>(kPoolTile * kPoolTile * 3));
  for (std::uint32_t i = 0; i < stored; ++i) {
    VT_CHECK(check_interrupt());
    const std::int64_t chosen = all * i / stored;  // spread over the whole image
    VT_CHECK(image.read({chosen % columns * kPoolTile, chosen / columns * kPoolTile, kPoolTile, kPoolTile}, kRgb, tile, kPoolTile * 3));
    VT_CHECK(writer.add_tile(tile));
  }
  return writer.finish(scattered_tiles(spec.columns(), spec.rows(), stored));
}

}  // namespace vt::bench
