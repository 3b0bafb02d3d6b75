#include "tests/store/store_support.h"

#include <algorithm>
#include <fstream>

#include "store/format/layout.h"
#include "store/texel/half.h"

namespace vt::store::test {

Bytes read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path.string() + ": cannot open");
  Bytes bytes(std::filesystem::file_size(path));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error(path.string() + ": cannot write");
}

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

LayerInfo small_layer(std::string name, TexelFormat format, int tile_exponent, int finest) {
  LayerInfo layer;
  layer.name = std::move(name);
  layer.format = format;
  layer.tile_exponent = static_cast<std::uint8_t>(tile_exponent);
  layer.finest = {static_cast<std::uint8_t>(finest)};
  const std::int64_t side = std::int64_t{1} << layer.vt_exponent();
  layer.data = {0, 0, side, side};
  layer.grid = {.origin_x = 0.0, .origin_y = 1.0, .step_x = 1.0 / static_cast<double>(side), .step_y = 1.0 / static_cast<double>(side)};
  return layer;
}

Bytes tile_bytes(const LayerInfo& layer, TileId tile, int version) {
  Bytes bytes(layer.tile_payload_bytes());
  std::uint64_t state = morton_code(tile.x, tile.y) * 977 + tile.level.value * 131 + static_cast<std::uint64_t>(version) * 7919 + 1;
  for (char c : layer.name) state = state * 31 + static_cast<unsigned char>(c);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    state = state * 6364136223846793005 + 1442695040888963407;
    bytes[i] = i < bytes.size() / 2 ? static_cast<std::byte>(state >> 56) : static_cast<std::byte>(tile.x + version);
  }
  return bytes;
}

EncodedPayload encoded(std::span<const std::byte> raw, Compression compression) { return value_of(encode_payload(raw, {}, compression)); }

EncodedPayload encoded(const LayerInfo& layer, std::span<const std::byte> raw, Compression compression) {
  return value_of(encode_payload(raw, tile_shape(layer.format, layer.tile_texels()), compression));
}

Bytes smooth_tile_bytes(const LayerInfo& layer, TileId tile) {
  const TileShape shape = tile_shape(layer.format, layer.tile_texels());
  Bytes bytes = tile_bytes(layer, tile);
  if (!shape.is_predictable()) return bytes;
  for (std::size_t y = 0; y < shape.height; ++y) {
    for (std::size_t x = 0; x < shape.width; ++x) {
      for (std::size_t c = 0; c < shape.channels; ++c) {
        const std::size_t sample = (y * shape.width + x) * shape.channels + c;
        std::uint32_t noise = static_cast<std::uint32_t>(sample + 1) * 2654435761U;
        noise = (noise ^ (noise >> 15)) * 2246822519U;
        noise ^= noise >> 13;
        switch (shape.samples) {
          case TileShape::Samples::kUint8:
            bytes[sample] = static_cast<std::byte>((c + 2) * x / 4 + y / 3 + 100 * c + tile.x + noise % 6);
            break;
          case TileShape::Samples::kUint16:
            put<std::uint16_t>(bytes, 2 * sample, static_cast<std::uint16_t>(300 * x + 500 * y + 9000 * c + noise % 40));
            break;
          case TileShape::Samples::kFloat16: {
            const float slope = 0.25F * static_cast<float>(x + y) - 4.0F;
            put<std::uint16_t>(bytes, 2 * sample, half_from_float(slope + 1e-2F * static_cast<float>(noise % 10)));
            break;
          }
          case TileShape::Samples::kFloat32: {
            const float slope = 3.0F * static_cast<float>(x + tile.x) + 5.0F * static_cast<float>(y) - 300.0F;
            put<std::uint32_t>(bytes, 4 * sample, std::bit_cast<std::uint32_t>(slope + 1e-3F * static_cast<float>(noise % 1000)));
            break;
          }
          case TileShape::Samples::kOpaque:
            break;
        }
      }
    }
  }
  return bytes;
}

Contents read_all(const StoreReader& reader) {
  Contents contents;
  for (const LayerInfo& layer : reader.layers()) {
    for (int level = 0; level <= layer.finest.value; ++level) {
      const std::uint32_t side = std::uint32_t{1} << level;
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          const TileId tile{Level{static_cast<std::uint8_t>(level)}, x, y};
          if (value_of(reader.lookup(layer.id, tile)).kind == TileKind::kAbsent) continue;
          Bytes bytes(layer.tile_payload_bytes());
          succeed(layer.holds_blobs() ? reader.read_blob(layer.id, tile, bytes) : reader.read(layer.id, tile, bytes));
          contents[{layer.name, tile}] = std::move(bytes);
        }
      }
    }
  }
  return contents;
}

}  // namespace vt::store::test
