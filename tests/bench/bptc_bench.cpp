// Mpx/s and quality of the BC7 and BC6H encoders at each quality, and Mpx/s of the decoders, one thread.
#include <benchmark/benchmark.h>

#include <string>
#include <type_traits>

#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "tests/encode/bptc/bc6h_definition.h"
#include "tests/encode/bptc/bc6h_images.h"
#include "tests/encode/bptc/bc7_definition.h"
#include "tests/encode/bptc/bc7_images.h"

namespace vt::encode {
namespace {

constexpr std::size_t kEdge = 512;

constexpr std::array<std::pair<const char*, Quality>, 3> kQualities{
    {{"fast", Quality::kFast}, {"normal", Quality::kNormal}, {"best", Quality::kBest}}};

void count_texels(benchmark::State& state, std::size_t texels) {
  state.counters["Mpx/s"] = benchmark::Counter(static_cast<double>(texels) * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
}

void add_bc7(const std::string& name, const RgbaImage& image, int channels) {
  for (const auto& [quality_name, quality] : kQualities) {
    benchmark::RegisterBenchmark(("bc7/" + name + "/" + quality_name).c_str(),
                                 [image, channels, quality = quality](benchmark::State& state) {
                                   for (auto _ : state) benchmark::DoNotOptimize(encoded_bc7(image, quality));
                                   count_texels(state, image.width * image.height);
                                   state.counters["dB"] = bc7_psnr_db(image, encoded_bc7(image, quality), channels);
                                 })
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.2);
  }
  benchmark::RegisterBenchmark(("bc7/" + name + "/decode").c_str(), [image](benchmark::State& state) {
    const std::vector<std::byte> blocks = encoded_bc7(image, Quality::kNormal);
    std::vector<std::byte> rgba(image.rgba.size());
    for (auto _ : state) {
      store::decode_bc7_image(blocks, image.width, image.height, rgba);
      benchmark::ClobberMemory();
    }
    count_texels(state, image.width * image.height);
  })->Unit(benchmark::kMillisecond);
}

// The plain definitions, one block at a time without vectors: what the encoders' rates are measured against.
template <std::size_t channels, class Value, class Texels>
Texels block_of(const std::vector<Value>& values, std::size_t width, std::size_t block) {
  Texels texels{};
  const std::size_t corner = block / (width / 4) * 4 * width + block % (width / 4) * 4;
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t c = 0; c < channels; ++c)
      texels[i][c] = static_cast<std::remove_cvref_t<decltype(texels[0][0])>>(values[(corner + i / 4 * width + i % 4) * 4 + c]);
  return texels;
}

void add_definitions(const RgbaImage& color, const HalfImage& light) {
  for (const auto& [quality_name, quality] : kQualities) {
    benchmark::RegisterBenchmark((std::string("bc7/definition/") + quality_name).c_str(), [color,
                                                                                           quality = quality](benchmark::State& state) {
      for (auto _ : state)
        for (std::size_t block = 0; block < color.width * color.height / 16; ++block)
          benchmark::DoNotOptimize(
              encode_bc7_block_by_definition(block_of<4, std::byte, RgbaTexels>(color.rgba, color.width, block), quality));
      count_texels(state, color.width * color.height);
    })->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark((std::string("bc6h/definition/") + quality_name).c_str(), [light,
                                                                                            quality = quality](benchmark::State& state) {
      for (auto _ : state)
        for (std::size_t block = 0; block < light.width * light.height / 16; ++block)
          benchmark::DoNotOptimize(
              encode_bc6h_block_by_definition(block_of<3, std::uint16_t, HalfTexels>(light.rgba, light.width, block), quality));
      count_texels(state, light.width * light.height);
    })->Unit(benchmark::kMillisecond);
  }
}

void add_bc6h(const std::string& name, const HalfImage& image) {
  for (const auto& [quality_name, quality] : kQualities) {
    benchmark::RegisterBenchmark(("bc6h/" + name + "/" + quality_name).c_str(),
                                 [image, quality = quality](benchmark::State& state) {
                                   for (auto _ : state) benchmark::DoNotOptimize(encoded_bc6h(image, quality));
                                   count_texels(state, image.width * image.height);
                                   const std::vector<std::byte> blocks = encoded_bc6h(image, quality);
                                   state.counters["rms_octaves"] = rms_octaves(image, blocks);
                                   const std::array<double, 3> ratios = light_ratios(image, blocks);
                                   state.counters["light_r"] = ratios[0] - 1;
                                   state.counters["light_g"] = ratios[1] - 1;
                                   state.counters["light_b"] = ratios[2] - 1;
                                 })
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.2);
  }
  benchmark::RegisterBenchmark(("bc6h/" + name + "/decode").c_str(), [image](benchmark::State& state) {
    const std::vector<std::byte> blocks = encoded_bc6h(image, Quality::kNormal);
    std::vector<std::byte> halves(image.rgba.size() * 2);
    for (auto _ : state) {
      store::decode_bc6h_image(blocks, image.width, image.height, halves);
      benchmark::ClobberMemory();
    }
    count_texels(state, image.width * image.height);
  })->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace vt::encode

int main(int argc, char** argv) {
  using namespace vt::encode;
  add_bc7("photographic", RgbaImage(photographic_image(kEdge, kEdge, 1)), 3);
  add_bc7("photographic_alpha", photographic_alpha_image(kEdge, kEdge, 1), 4);
  add_bc7("noise", noise_rgba_image(kEdge, kEdge, 1), 4);
  for (const char* name : kRealImages)
    if (const auto image = real_image(name)) add_bc7(name, RgbaImage(*image), 3);
  add_bc6h("day", day_image(kEdge, kEdge, 1));
  add_bc6h("night", night_image(kEdge, kEdge, 1));
  add_bc6h("noise_6_octaves", noise_half_image(kEdge, kEdge, 6, 1));
  add_definitions(RgbaImage(photographic_image(128, 128, 1)), day_image(128, 128, 1));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
