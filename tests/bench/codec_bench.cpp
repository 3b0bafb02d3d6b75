// MB/s (of raw bytes, one thread) and size ratio of the store's compression beside plain zstd of the same
// level, on tiles of real rasters: files named on the command line (three bands of bytes, or one of 32-bit
// floats, which are also tried in 16 bits), or those of the test data.
//   codec_bench big.tif --benchmark_filter=zstd:1/
#include <benchmark/benchmark.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "store/codec/codec.h"
#include "store/io/bytes.h"
#include "store/texel/half.h"

namespace vt::store {
namespace {

constexpr std::int64_t kEdge = 256;
constexpr std::size_t kMaxTiles = 64;

struct Tiles {
  std::string name;
  TexelFormat format = TexelFormat::kRgb8;
  std::vector<std::vector<std::byte>> raw;
};

// Whole tiles, evenly over the raster.
Result<Tiles> read_tiles(const std::filesystem::path& path) {
  VT_ASSIGN(const auto raster, source::open_raster(path));
  const source::RasterInfo& info = raster->info();
  Tiles tiles{.name = path.stem().string(), .format = TexelFormat::kRgb8, .raw = {}};
  std::vector<int> bands = {0, 1, 2};
  if (info.sample_type == SampleType::kFloat32) {
    tiles.format = TexelFormat::kR32Float;
    bands = {0};
  }
  if (info.bands < static_cast<int>(bands.size()) || (bands.size() == 3 && info.sample_type != SampleType::kUint8))
    return fail(ErrorCode::kUnsupported, path.string() + ": neither three bands of bytes nor floats");
  const std::int64_t columns = info.width / kEdge;
  const std::int64_t count = columns * (info.height / kEdge);
  // Odd, so as not to go down one column of a raster whose width is a power of two.
  const std::int64_t step = (count / static_cast<std::int64_t>(kMaxTiles)) | 1;
  const std::size_t texel_bytes = format_info(tiles.format).block_bytes;
  for (std::int64_t i = 0; i < count; i += step) {
    std::vector<std::byte> tile(texel_bytes * kEdge * kEdge);
    VT_CHECK(raster->read({i % columns * kEdge, i / columns * kEdge, kEdge, kEdge}, bands, tile, texel_bytes * kEdge));
    tiles.raw.push_back(std::move(tile));
  }
  return tiles;
}

// The same heights in 16 bits a sample: as halves, or in tenths of a metre.
Tiles in_16_bits(const Tiles& floats, TexelFormat format) {
  Tiles tiles{.name = floats.name + "_" + std::string(format_info(format).name), .format = format, .raw = {}};
  for (const auto& raw : floats.raw) {
    std::vector<std::byte> tile(raw.size() / 2);
    for (std::size_t i = 0; i < raw.size() / 4; ++i) {
      const auto height_m = std::bit_cast<float>(get<std::uint32_t>(raw, 4 * i));
      const float tenths = 10.0F * height_m + 5000.0F;
      const auto code = static_cast<std::uint16_t>(tenths > 0.0F ? std::min(tenths, 65535.0F) : 0.0F);  // also of NaN
      put<std::uint16_t>(tile, 2 * i, format == TexelFormat::kR16 ? code : half_from_float(height_m));
    }
    tiles.raw.push_back(std::move(tile));
  }
  return tiles;
}

std::size_t total_bytes(const std::vector<std::vector<std::byte>>& tiles) {
  return std::accumulate(tiles.begin(), tiles.end(), std::size_t{0}, [](std::size_t sum, const auto& tile) { return sum + tile.size(); });
}

void run(benchmark::State& state, const Tiles& tiles, const TileShape& shape, int level, bool decodes) {
  std::vector<EncodedPayload> payloads;
  std::size_t stored = 0;
  for (const auto& raw : tiles.raw) {
    payloads.push_back(encode_payload(raw, shape, {Codec::kZstd, level}).value());
    stored += payloads.back().bytes.size();
  }
  std::vector<std::byte> scratch;
  std::vector<std::byte> out(tiles.raw.front().size());
  for (auto _ : state) {
    for (std::size_t i = 0; i < payloads.size(); ++i) {
      if (decodes) {
        if (!decode_payload(payloads[i].codec, payloads[i].bytes, shape, out)) state.SkipWithError("a payload does not decode");
      } else {
        benchmark::DoNotOptimize(encode_payload(tiles.raw[i], shape, {Codec::kZstd, level}, scratch));
      }
    }
  }
  const auto raw = static_cast<double>(total_bytes(tiles.raw));
  state.counters["MB/s"] = benchmark::Counter(raw * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["ratio"] = static_cast<double>(stored) / raw;
}

void add(const Tiles& tiles) {
  for (const int level : {1, 3, 9}) {
    for (const bool is_plain : {false, true}) {
      const TileShape shape = is_plain ? TileShape{} : tile_shape(tiles.format, kEdge);
      for (const bool decodes : {false, true}) {
        const std::string name =
            tiles.name + "/zstd:" + std::to_string(level) + (is_plain ? "/plain" : "/predicted") + (decodes ? "/decode" : "/encode");
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) { run(state, tiles, shape, level, decodes); })
            ->Unit(benchmark::kMillisecond)
            ->MinTime(0.2);
      }
    }
  }
}

}  // namespace
}  // namespace vt::store

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  std::vector<std::filesystem::path> files(argv + 1, argv + argc);
  const std::filesystem::path data = VT_TEST_DATA;
  if (files.empty()) {
    for (const char* name : {"imagery/deepforest_5dded5_jpeg_epsg3395.tif", "imagery/farm_cir_2m.tif",
                             "imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif", "imagery/everest_LE71400412000304SGS00_RGB.tif",
                             "elevation/dom1_32_356_5699_1_nw_2020.tif", "elevation/swellendam_srtm_41_19_4326.tif"})
      files.push_back(data / name);
  }
  for (const auto& file : files) {
    const auto tiles = vt::store::read_tiles(file);
    if (tiles && !tiles->raw.empty()) {
      vt::store::add(*tiles);
      if (tiles->format != vt::TexelFormat::kR32Float) continue;
      for (const auto format : {vt::TexelFormat::kR16, vt::TexelFormat::kR16Float}) vt::store::add(vt::store::in_16_bits(*tiles, format));
    } else {
      std::fprintf(stderr, "%s: passed over: %s\n", file.c_str(), tiles ? "smaller than a tile" : tiles.error().message.c_str());
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
