// Mpx/s and PSNR of the BC1 encoder at each quality beside stb_dxt in its high-quality mode and libsquish's
// cluster fit, one thread.
#include <benchmark/benchmark.h>

#include <string>

#include "builder/encode/bc1/bc1_encoder.h"
#include "tests/encode/bc1/bc1_images.h"
#include "tests/encode/bc1/squish_encoder.h"

namespace vt::encode {
namespace {

using Encoder = std::vector<std::byte> (*)(const Image&);

template <Quality quality>
std::vector<std::byte> encoded_at(const Image& image) {
  std::vector<std::byte> blocks(image.width * image.height / 2);
  encode_bc1_image(image.rgb, image.width, image.height, image.width * 3, 3, quality, blocks);
  return blocks;
}
std::vector<std::byte> encoded_by_cluster_fit(const Image& image) { return encoded_by_squish(image, false); }

void run(benchmark::State& state, const Image& image, Encoder encode) {
  for (auto _ : state) benchmark::DoNotOptimize(encode(image));
  const double megatexels = static_cast<double>(image.width * image.height) * 1e-6;
  state.counters["Mpx/s"] = benchmark::Counter(megatexels, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["dB"] = psnr_db(mean_squared_error(image, encode(image)));
}

void add(const std::string& name, const Image& image) {
  for (const auto& [encoder, encode] : {std::pair<const char*, Encoder>{"fast", encoded_at<Quality::kFast>},
                                        {"vt", encoded},
                                        {"best", encoded_at<Quality::kBest>},
                                        {"stb_hq", encoded_by_stb},
                                        {"squish_cluster", encoded_by_cluster_fit}})
    benchmark::RegisterBenchmark((name + "/" + encoder).c_str(),
                                 [image, encode = encode](benchmark::State& state) { run(state, image, encode); })
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.2);
}

}  // namespace
}  // namespace vt::encode

int main(int argc, char** argv) {
  using namespace vt::encode;
  add("photographic_1024", photographic_image(1024, 1024, 1));
  add("noise_1024", noise_image(1024, 1024, 1));
  for (const char* name : kRealImages)
    if (const auto image = real_image(name)) add(name, *image);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
