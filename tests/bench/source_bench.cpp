// Opening many small files: what a mosaic of ten thousand pieces pays before its first sample.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "builder/source/cells/block_cache.h"
#include "builder/source/files/file_pool.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

constexpr int kFiles = 10000;

// Written once for all runs; every file is 512 x 512 and placed, as pieces of a mosaic are.
const std::vector<std::filesystem::path>& mosaic() {
  static const test::TempFolder folder;
  static const std::vector<std::filesystem::path> paths = [] {
    std::vector<std::filesystem::path> made;
    const std::vector<std::byte> samples(512 * 512 * 3, std::byte{77});
    for (int i = 0; i < kFiles; ++i) {
      GeoTiffSpec spec;
      spec.width = spec.height = 512;
      spec.bands = 3;
      spec.compression = GeoTiffSpec::Compression::kDeflate;
      spec.tile = 256;
      spec.crs = geo::Crs::from_epsg(32633).value();
      spec.transform = geo::GeoTransform{
          .x0 = 3e5 + i % 100 * 512.0, .x_column = 1, .x_row = 0, .y0 = 5e6 - i / 100 * 512.0, .y_column = 0, .y_row = -1};
      made.push_back(folder / (std::to_string(i) + ".tif"));
      auto writer = GeoTiffWriter::create(made.back(), spec);
      if (!writer || !writer->write_rows(samples, 512) || !writer->finish()) throw std::runtime_error("the mosaic cannot be written");
    }
    return made;
  }();
  return paths;
}

// Items are files; all stay open together, as in a build.
void open_mosaic(benchmark::State& state) {
  const auto& paths = mosaic();
  double bytes_each = 0.0;
  for (auto _ : state) {
    const std::size_t before = mallinfo2().uordblks;
    OpenOptions options;
    options.files = std::make_shared<FilePool>();
    options.cache = std::make_shared<BlockCache>(std::size_t{64} << 20);
    std::vector<std::unique_ptr<RasterSource>> sources;
    sources.reserve(paths.size());
    for (const auto& path : paths) {
      auto source = open_raster(path, options);
      if (!source) {
        state.SkipWithError(source.error().message.c_str());
        return;
      }
      sources.push_back(std::move(*source));
    }
    bytes_each = static_cast<double>(mallinfo2().uordblks - before) / kFiles;
    state.PauseTiming();
    sources.clear();
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * kFiles);
  state.counters["heap_bytes_each"] = bytes_each;
}
BENCHMARK(open_mosaic)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vt::source

BENCHMARK_MAIN();
