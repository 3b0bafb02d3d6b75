// Mpx/s and mean squared error (in codes) of the BC4 and BC5 encoder at each quality, beside stb_dxt and
// libsquish, one thread. A pixel of BC5 is two samples.
#include <benchmark/benchmark.h>

#include <functional>
#include <string>

#include "tests/encode/bc4/bc4_images.h"

namespace vt::encode {
namespace {

using Encoder = std::function<std::vector<std::byte>(const Image16&)>;

void add(const std::string& name, const Image16& image) {
  const std::pair<const char*, Encoder> encoders[] = {
      {"fast", [](const Image16& from) { return encoded(from, Quality::kFast); }},
      {"normal", [](const Image16& from) { return encoded(from, Quality::kNormal); }},
      {"best", [](const Image16& from) { return encoded(from, Quality::kBest); }},
      {"stb", encoded_by_stb},
      {"squish", encoded_by_squish},
  };
  for (const auto& [encoder, encode] : encoders)
    benchmark::RegisterBenchmark((name + "/" + encoder).c_str(),
                                 [image, encode = encode](benchmark::State& state) {
                                   for (auto _ : state) benchmark::DoNotOptimize(encode(image));
                                   const double megatexels = static_cast<double>(image.width * image.height) * 1e-6;
                                   state.counters["Mpx/s"] = benchmark::Counter(megatexels, benchmark::Counter::kIsIterationInvariantRate);
                                   const std::vector<std::byte> blocks = encode(image);
                                   state.counters["mse"] = mean_squared_error(image, blocks);
                                   if (image.channels == 2) state.counters["mean_deg"] = angular_error(image, blocks).mean_deg;
                                 })
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.2);
}

}  // namespace
}  // namespace vt::encode

int main(int argc, char** argv) {
  using namespace vt::encode;
  for (const auto& [name, image] : scalar_images(256)) add(name, image);
  add("normals", normals_image(256, 1));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
