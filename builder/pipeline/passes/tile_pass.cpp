#include "builder/pipeline/passes/tile_pass.h"

#include "store/texel/texel_decoder.h"

namespace vt::pipeline {

Result<void> for_each_tile(const LayerInfo& layer, Level level, int threads, const std::atomic<bool>* cancel, const TileUse& use) {
  const TexelRect tiles = layer.tile_rect(level);
  return for_each_index(static_cast<std::size_t>(tiles.height), threads, [&](std::size_t row) -> Result<void> {
    const auto y = static_cast<std::uint32_t>(tiles.y + static_cast<std::int64_t>(row));
    for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
      if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return fail(ErrorCode::kCancelled, "stopped");
      VT_CHECK(use(row, TileId{level, static_cast<std::uint32_t>(x), y}));
    }
    return {};
  });
}

Result<bool> read_samples(const store::StoreWriter& writer, const LayerInfo& layer, LayerId id, const TileId& tile,
                          std::vector<float>& samples) {
  samples.clear();
  if (!writer.contains(id, tile)) return false;
  std::vector<std::byte> payload(layer.tile_payload_bytes());
  VT_CHECK(writer.read(id, tile, payload));
  const std::size_t edge = layer.tile_texels();
  samples.resize(edge * edge * format_info(layer.format).channels);
  store::decode_texels(layer.format, payload, edge, edge, samples);
  return true;
}

}  // namespace vt::pipeline
