#include "builder/pipeline/sources/stored_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "builder/pipeline/sources/sample_windows.h"

namespace vt::pipeline {
namespace {

constexpr int kLeastOctave = -14;        // of normal halves
constexpr int kBrightestOctave = 9;      // of what is stored, at the brightest that was seen
constexpr int kLeastScaleOctave = -126;  // floats hold the scale and its reciprocal
constexpr double kSmallShare = 1e-3;     // of light that may be lost

// Light by octaves, over texels and the three colours.
struct LightSeen {
  double total = 0.0;
  double in_small_numbers = 0.0;
  double texels = 0.0;  // with and without light, three colours each
  int brightest_octave = -200;

  void add(double light) {
    texels += 1.0;
    if (!(light > 0.0) || !std::isfinite(light)) return;
    const int octave = std::ilogb(light);
    total += light;
    if (octave < kLeastOctave) in_small_numbers += light;
    brightest_octave = std::max(brightest_octave, octave);
  }
  [[nodiscard]] bool is_small() const {
    return total > 0.0 && (in_small_numbers > kSmallShare * total || total / texels < std::ldexp(1.0, kLeastOctave));
  }
};

Result<void> look_at(const resample::PlacedSource& source, const source::Window& window, LightSeen& seen) {
  const std::size_t pitch = static_cast<std::size_t>(window.width) * source.layout.texel_bytes();
  std::vector<std::byte> samples(pitch * static_cast<std::size_t>(window.height));
  VT_CHECK(source.read(window, samples, pitch, nullptr));
  const auto planes = static_cast<std::size_t>(source.codec->source_planes());
  std::vector<float> floats(planes * static_cast<std::size_t>(window.width));
  channels::PlaneRow row{};
  for (std::size_t p = 0; p < planes; ++p) row[p] = floats.data() + p * static_cast<std::size_t>(window.width);
  for (std::int64_t y = 0; y < window.height; ++y) {
    source.codec->decode_row(samples.data() + static_cast<std::size_t>(y) * pitch, window.width, row);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::int64_t x = 0; x < window.width; ++x) seen.add(row[c][x]);
  }
  return {};
}

}  // namespace

Result<double> choose_stored_light(std::span<const SourcePlaces> sources) {
  LightSeen seen;
  VT_CHECK(look_at_windows(
      sources, [&](const resample::PlacedSource& source, const source::Window& window) { return look_at(source, window, seen); }));
  return seen.is_small() ? std::min(1.0, std::ldexp(1.0, std::max(seen.brightest_octave - kBrightestOctave, kLeastScaleOctave))) : 1.0;
}

}  // namespace vt::pipeline
