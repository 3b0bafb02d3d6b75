// Mpx/s and PSNR of the BC1 encoder beside stb_dxt in its high-quality mode, one thread.
#include <benchmark/benchmark.h>

#include <string>

#include "tests/encode/bc1_images.h"

namespace vt::encode {
namespace {

using Encoder = std::vector<std::byte> (*)(const Image&);

void run(benchmark::State& state, const Image& image, Encoder encode) {
  for (auto _ : state) benchmark::DoNotOptimize(encode(image));
  const double megatexels = static_cast<double>(image.width * image.height) * 1e-6;
  state.counters["Mpx/s"] = benchmark::Counter(megatexels, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["dB"] = psnr_db(mean_squared_error(image, encode(image)));
}

void add(const std::string& name, const Image& image) {
  for (const auto& [encoder, encode] : {std::pair<const char*, Encoder>{"vt", encoded}, {"stb_hq", encoded_by_stb}})
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
