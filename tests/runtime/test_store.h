// Small stores whose texels are known by formula, and sources that watch or slow down the loader.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "runtime/tile_source.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "tests/support/temp_folder.h"

namespace vt::runtime::test {

using vt::test::TempFolder;

inline std::uint32_t hash_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::uint32_t h = a * 0x9E3779B1U ^ b * 0x85EBCA77U ^ c * 0xC2B2AE3DU;
  h ^= h >> 15;
  h *= 0x2C1B3CE3U;
  h ^= h >> 12;
  h *= 0x297A2D39U;
  return h ^ (h >> 15);
}

// Writes one texel (or one block, for block formats, x and y counted in blocks).
using Paint = std::function<void(Level level, std::int64_t x, std::int64_t y, std::byte* block)>;

// Every level its own noise: a byte that comes from the wrong level, column or row is found.
inline Paint noise_paint(TexelFormat format) {
  const int bytes = format_info(format).block_bytes;
  return [bytes](Level level, std::int64_t x, std::int64_t y, std::byte* block) {
    for (int i = 0; i < bytes; ++i)
      block[i] = static_cast<std::byte>(
          hash_of(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), level.value * 16U + static_cast<unsigned>(i)));
  };
}

struct LayerSpec {
  std::string name = "colour";
  ChannelType channel = ChannelType::kColor;
  TexelFormat format = TexelFormat::kRgb8;
  int tile_exponent = 6;
  int finest = 4;
  TexelRect data;                    // empty: the whole padded square
  Paint paint;                       // null: noise
  std::function<bool(TileId)> skip;  // tiles that are left out
  bool is_point_sampled = false;
  ComponentRange range;  // of the first component
  bool zero_is_nodata = false;
};

inline LayerInfo layer_info(const LayerSpec& spec, const Area& area) {
  LayerInfo info;
  info.name = spec.name;
  info.channel = spec.channel;
  info.format = spec.format;
  info.is_point_sampled = spec.is_point_sampled;
  info.components[0] = spec.range;
  info.zero_is_nodata = spec.zero_is_nodata;
  info.tile_exponent = static_cast<std::uint8_t>(spec.tile_exponent);
  info.finest = Level{static_cast<std::uint8_t>(spec.finest)};
  const std::int64_t width = std::int64_t{1} << (spec.finest + spec.tile_exponent);
  info.data = spec.data.empty() ? TexelRect{0, 0, width, width} : spec.data;
  info.grid = {.origin_x = area.west,
               .origin_y = area.north,
               .step_x = (area.east - area.west) / static_cast<double>(info.data.width),
               .step_y = (area.north - area.south) / static_cast<double>(info.data.height)};
  return info;
}

inline Result<void> write_layer(store::StoreWriter& writer, const LayerSpec& spec, const Area& area) {
  const LayerInfo info = layer_info(spec, area);
  VT_ASSIGN(const LayerId id, writer.add_layer(info));
  const FormatInfo& format = format_info(info.format);
  const Paint paint = spec.paint ? spec.paint : noise_paint(spec.format);
  const std::int64_t blocks = info.tile_texels() / format.block_edge;
  std::vector<std::byte> bytes(info.tile_payload_bytes());
  for (int value = 0; value <= spec.finest; ++value) {
    const Level level{static_cast<std::uint8_t>(value)};
    const TexelRect tiles = info.tile_rect(level);
    for (std::int64_t ty = tiles.y; ty < tiles.bottom(); ++ty) {
      for (std::int64_t tx = tiles.x; tx < tiles.right(); ++tx) {
        const TileId tile{level, static_cast<std::uint32_t>(tx), static_cast<std::uint32_t>(ty)};
        if (spec.skip && spec.skip(tile)) continue;
        for (std::int64_t y = 0; y < blocks; ++y)
          for (std::int64_t x = 0; x < blocks; ++x)
            paint(level, tx * blocks + x, ty * blocks + y, bytes.data() + static_cast<std::size_t>((y * blocks + x) * format.block_bytes));
        VT_ASSIGN(const store::EncodedPayload payload, store::encode_payload(bytes, {}, {}));
        VT_CHECK(writer.put(id, tile, payload));
      }
    }
  }
  return writer.set_state(id, LayerState::kComplete);
}

inline Result<std::shared_ptr<const store::StoreReader>> make_store(const std::filesystem::path& path, const std::vector<LayerSpec>& layers,
                                                                    const Area& area = {.west = 0, .south = 0, .east = 1, .north = 1}) {
  VT_ASSIGN(store::StoreWriter writer,
            store::StoreWriter::create(path, {.area = area, .metadata_json = "{}"}, {.before_operation = nullptr, .sync = false}));
  for (const LayerSpec& layer : layers) VT_CHECK(write_layer(writer, layer, area));
  VT_CHECK(writer.finish());
  VT_ASSIGN(store::StoreReader reader, store::StoreReader::open(path));
  return std::make_shared<const store::StoreReader>(std::move(reader));
}

// Texels by formula, with no store: for virtual textures of any nominal size. Counts, watches threads, fails
// or waits on demand.
class PaintedSource final : public TileSource {
 public:
  PaintedSource(TexelFormat format, Paint paint) : format_(format), paint_(std::move(paint)) {}

  Result<void> read(Level level, const TexelRect& rect, std::span<std::byte> out) override {
    last_thread = std::this_thread::get_id();
    ++reads;
    if (during_read) during_read();
    if (fail_level.load() == level.value) return fail(ErrorCode::kCorrupt, "painted to fail");
    const FormatInfo& format = format_info(format_);
    std::byte* to = out.data();
    for (std::int64_t y = rect.y / format.block_edge; y < rect.bottom() / format.block_edge; ++y)
      for (std::int64_t x = rect.x / format.block_edge; x < rect.right() / format.block_edge; ++x, to += format.block_bytes)
        paint_(level, x, y, to);
    return {};
  }

  std::atomic<std::thread::id> last_thread{};
  std::atomic<int> reads{0};
  std::atomic<int> fail_level{-1};
  std::function<void()> during_read;  // called inside every read: may take as long as it likes

 private:
  TexelFormat format_;
  Paint paint_;
};

}  // namespace vt::runtime::test
