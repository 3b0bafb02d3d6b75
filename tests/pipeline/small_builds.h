// Small rasters on disk, built into stores, and the stores' tiles in memory.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/blocks/dataset_store.h"
#include "builder/pipeline/build/layer_build.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "store/store_reader.h"
#include "tests/support/temp_folder.h"

namespace vt::pipeline {

inline geo::Crs utm33() { return geo::Crs::from_epsg(32633).value(); }

struct RasterSpec {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 3;
  SampleType type = SampleType::kUint8;
  bool alpha = false;
  std::optional<double> nodata;
  geo::GeoTransform transform{500000.0, 2.0, 0.0, 5400000.0, 0.0, -2.0};
  int epsg = 32633;
  int tile = 64;
  source::GeoTiffSpec::Compression compression = source::GeoTiffSpec::Compression::kNone;
};

// `value(x, y, band)` is converted to the sample type.
inline void write_raster(const std::filesystem::path& path, const RasterSpec& spec,
                         const std::function<double(std::int64_t, std::int64_t, int)>& value) {
  source::GeoTiffSpec tiff;
  tiff.width = spec.width;
  tiff.height = spec.height;
  tiff.bands = spec.bands;
  tiff.sample_type = spec.type;
  tiff.last_band_is_alpha = spec.alpha;
  tiff.nodata = spec.nodata;
  tiff.transform = spec.transform;
  tiff.crs = geo::Crs::from_epsg(spec.epsg).value();
  tiff.tile = spec.tile;
  tiff.compression = spec.compression;
  auto writer = source::GeoTiffWriter::create(path, tiff);
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  const std::size_t bytes = sample_bytes(spec.type);
  std::vector<std::byte> row(static_cast<std::size_t>(spec.width * spec.bands) * bytes);
  for (std::int64_t y = 0; y < spec.height; ++y) {
    std::byte* out = row.data();
    for (std::int64_t x = 0; x < spec.width; ++x)
      for (int b = 0; b < spec.bands; ++b, out += bytes) {
        const double v = value(x, y, b);
        const auto put = [&](auto typed) { std::memcpy(out, &typed, sizeof typed); };
        switch (spec.type) {
          case SampleType::kUint8:
            put(static_cast<std::uint8_t>(v));
            break;
          case SampleType::kInt16:
            put(static_cast<std::int16_t>(v));
            break;
          case SampleType::kUint16:
            put(static_cast<std::uint16_t>(v));
            break;
          case SampleType::kFloat32:
            put(static_cast<float>(v));
            break;
          case SampleType::kFloat64:
            put(v);
            break;
          case SampleType::kInt32:
            put(static_cast<std::int32_t>(v));
            break;
          case SampleType::kUint32:
            put(static_cast<std::uint32_t>(v));
            break;
          default:
            FAIL() << "not used here";
        }
      }
    ASSERT_TRUE(writer->write_rows(row, 1).has_value());
  }
  ASSERT_TRUE(writer->finish().has_value());
}

inline LayerRequest request_for(const std::vector<std::filesystem::path>& inputs, ChannelType channel) {
  LayerRequest request;
  request.channel = channel;
  request.name = channels::kind_of(channel).name;
  for (const auto& input : inputs) request.sources.push_back({.path = input});
  request.tile_texels = 32;
  return request;
}

// Plans and builds into a new store, or gives the first error of either.
inline Result<BuildReport> try_build(const std::filesystem::path& store_path, const LayerRequest& request,
                                     const BuildOptions& options = {}) {
  VT_ASSIGN(const auto frame, existing_frame(store_path));
  VT_ASSIGN(const LayerPlan plan, plan_layer(request, frame, std::size_t{8} << 20));
  VT_ASSIGN(store::StoreWriter writer, open_or_create(store_path, plan.crs, plan.extent()));
  VT_ASSIGN(const BuildReport report, build_layer(writer, plan, options));
  VT_CHECK(writer.finish());
  return report;
}

// Plans and builds into a new store; fails the test on any error.
inline BuildReport build(const std::filesystem::path& store_path, const LayerRequest& request, const BuildOptions& options = {}) {
  auto frame = existing_frame(store_path);
  EXPECT_TRUE(frame.has_value()) << frame.error().message;
  auto plan = plan_layer(request, *frame, std::size_t{8} << 20);
  EXPECT_TRUE(plan.has_value()) << (plan ? "" : plan.error().message);
  auto writer = open_or_create(store_path, plan->crs, plan->extent());
  EXPECT_TRUE(writer.has_value()) << (writer ? "" : writer.error().message);
  auto report = build_layer(*writer, *plan, options);
  EXPECT_TRUE(report.has_value()) << (report ? "" : report.error().message);
  EXPECT_TRUE(writer->finish().has_value());
  return report.value_or(BuildReport{});
}

using Tiles = std::map<TileId, std::vector<std::byte>>;

// Every tile that is present in one layer, decoded.
inline Tiles tiles_of(const std::filesystem::path& store_path, const std::string& layer_name) {
  Tiles tiles;
  auto reader = store::StoreReader::open(store_path);
  EXPECT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo* layer = reader->find_layer(layer_name);
  EXPECT_NE(layer, nullptr);
  for (int level = 0; level <= layer->finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect rect = layer->tile_rect(l);
    for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
      for (std::int64_t x = rect.x; x < rect.right(); ++x) {
        const TileId tile{l, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
        std::vector<std::byte> payload(layer->tile_payload_bytes());
        auto read = layer->holds_blobs() ? reader->read_blob(layer->id, tile, payload) : reader->read(layer->id, tile, payload);
        if (read) {
          tiles.emplace(tile, std::move(payload));
        } else {
          EXPECT_EQ(read.error().code, ErrorCode::kNotFound) << read.error().message;
        }
      }
  }
  return tiles;
}

// One texel of a plain format as unsigned bytes or a float, by position on its level.
template <class T, int kChannels>
std::array<T, kChannels> texel_at(const Tiles& tiles, int tile_exponent, Level level, std::int64_t x, std::int64_t y) {
  const std::int64_t edge = std::int64_t{1} << tile_exponent;
  const auto found = tiles.find({level, static_cast<std::uint32_t>(x >> tile_exponent), static_cast<std::uint32_t>(y >> tile_exponent)});
  EXPECT_NE(found, tiles.end()) << "no tile under texel " << x << ", " << y;
  std::array<T, kChannels> texel{};
  if (found == tiles.end()) return texel;
  const auto offset = static_cast<std::size_t>(((y & (edge - 1)) * edge + (x & (edge - 1)))) * sizeof texel;
  std::memcpy(texel.data(), found->second.data() + offset, sizeof texel);
  return texel;
}

// Repeatable noise without any generator state.
inline std::uint32_t hash_noise(std::int64_t x, std::int64_t y, int band) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
           static_cast<std::uint32_t>(band) * 0xC2B2AE3DU;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  h *= 0x297A2D39U;
  h ^= h >> 15;
  return h;
}

}  // namespace vt::pipeline
