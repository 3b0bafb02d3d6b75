#include "tests/cli/sample_store.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "builder/geo/crs.h"
#include "store/store_reader.h"
#include "store/store_writer.h"

namespace vt::test {

namespace {

// Set-up that fails is not what a test is about: stop it there.
template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

using FillTexel = std::function<void(Level, std::int64_t x, std::int64_t y, std::byte* texel)>;

void put_all_tiles(store::StoreWriter& writer, const LayerInfo& layer, LayerId id, const SampleStore& options, const FillTexel& fill) {
  const std::size_t texel_bytes = format_info(layer.format).block_bytes;
  std::vector<std::byte> payload(layer.tile_payload_bytes());
  for (int value = 0; value <= layer.finest.value; ++value) {
    const Level level{static_cast<std::uint8_t>(value)};
    const TexelRect tiles = layer.tile_rect(level);
    for (std::int64_t ty = tiles.y; ty < tiles.bottom(); ++ty) {
      for (std::int64_t tx = tiles.x; tx < tiles.right(); ++tx) {
        const TileId tile{level, static_cast<std::uint32_t>(tx), static_cast<std::uint32_t>(ty)};
        const bool is_color = layer.name == options.color_name;
        if (is_color && options.absent_color_tile == tile) continue;
        const TexelRect place = rect_of(tile, layer.tile_exponent);
        for (std::int64_t y = place.y; y < place.bottom(); ++y) {
          for (std::int64_t x = place.x; x < place.right(); ++x) {
            fill(level, x, y, &payload[static_cast<std::size_t>((y - place.y) * place.width + x - place.x) * texel_bytes]);
          }
        }
        if (is_color && options.changed_color_tile == tile) payload[0] = static_cast<std::byte>(std::to_integer<int>(payload[0]) + 2);
        value_of(writer.put(id, tile, value_of(store::encode_payload(payload, {}, {}))));
      }
    }
  }
}

}  // namespace

std::uint8_t color_code(Level level, std::int64_t x, std::int64_t y, int channel) {
  return static_cast<std::uint8_t>(20 + 7 * level.value + 3 * x + 2 * y + 40 * channel > 240
                                       ? (x * 5 + y * 3 + channel) % 200
                                       : 20 + 7 * level.value + 3 * x + 2 * y + 40 * channel);
}

float elevation_m(Level level, std::int64_t x, std::int64_t y) {
  if (level.value == 1 && x == 3 && y == 2) return std::numeric_limits<float>::quiet_NaN();
  return 100.25F + static_cast<float>(10 * x + y) + 1000.0F * static_cast<float>(1 - level.value);
}

void write_sample_store(const std::filesystem::path& path, const SampleStore& options) {
  const geo::Crs crs = value_of(geo::Crs::from_epsg(32633));
  store::StoreDescription description;
  description.area = {kWest, kNorth - 240.0, kWest + 400.0, kNorth};
  description.metadata_json = nlohmann::json{{"crs", crs.to_json()}, {"created_by", "test 1"}}.dump();
  store::WriterOptions writer_options;
  writer_options.sync = false;
  store::StoreWriter writer = value_of(store::StoreWriter::create(path, description, writer_options));

  LayerInfo color;
  color.name = options.color_name;
  color.channel = ChannelType::kColor;
  color.format = options.color_format;
  color.transfer = Transfer::kSrgb;
  color.tile_exponent = 4;
  color.finest = Level{2};
  color.data = kColorData;
  color.grid = {kWest, kNorth, 10.0, 10.0};
  color.metadata_json = R"({"sources":[{"path":"a.tif","width":40,"height":24}],"kernel":"box"})";
  const LayerId color_id = value_of(writer.add_layer(color));
  put_all_tiles(writer, color, color_id, options, [&](Level level, std::int64_t x, std::int64_t y, std::byte* texel) {
    for (int channel = 0; channel < 3; ++channel) texel[channel] = std::byte{color_code(level, x, y, channel)};
    if (color.format == TexelFormat::kRgba8) texel[3] = (x + y) % 2 == 0 ? std::byte{255} : std::byte{128};
  });
  value_of(writer.set_state(color_id, LayerState::kComplete));

  if (options.with_elevation) {
    LayerInfo elevation;
    elevation.name = "elevation";
    elevation.channel = ChannelType::kElevation;
    elevation.format = TexelFormat::kR32Float;
    elevation.tile_exponent = 4;
    elevation.finest = Level{1};
    elevation.data = kElevationData;
    elevation.grid = {kWest, kNorth, 20.0, 20.0};
    elevation.source_nodata = -9999.0;
    elevation.metadata_json = "{}";
    const LayerId id = value_of(writer.add_layer(elevation));
    put_all_tiles(writer, elevation, id, options, [](Level level, std::int64_t x, std::int64_t y, std::byte* texel) {
      const std::uint32_t quiet_nan = 0x7FC00000U;
      const float value = elevation_m(level, x, y);
      if (std::isnan(value)) {
        std::memcpy(texel, &quiet_nan, sizeof quiet_nan);
      } else {
        std::memcpy(texel, &value, sizeof value);
      }
    });
    value_of(writer.set_state(id, LayerState::kComplete));
  }

  if (options.with_carry) {
    LayerInfo carry = color;
    carry.name = options.color_name + ".carry";
    carry.role = LayerRole::kCarry;
    carry.owner = color_id;
    carry.format = TexelFormat::kR32Float;
    carry.transfer = Transfer::kLinear;
    const LayerId id = value_of(writer.add_layer(carry));
    const float one = 1.0F;
    value_of(writer.put_constant(id, {}, std::as_bytes(std::span(&one, 1))));
  }
  value_of(writer.finish());
}

void flip_bit(const std::filesystem::path& path, std::uint64_t offset) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekg(static_cast<std::streamoff>(offset));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(static_cast<char>(byte ^ 1));
  if (!file) throw std::runtime_error("flip_bit: " + path.string());
}

std::uint64_t tile_offset(const std::filesystem::path& path, const std::string& layer, TileId tile) {
  const store::StoreReader reader = value_of(store::StoreReader::open(path));
  const LayerInfo* const info = reader.find_layer(layer);
  if (info == nullptr) throw std::runtime_error("no layer " + layer);
  const store::TileLookup found = value_of(reader.lookup(info->id, tile));
  return found.offset;
}

}  // namespace vt::test
