// A scene of a given size as bands of 256 rows, made by all threads of the current TBB arena from squares,
// and its lights. Between the painter (one square) and sample_scene.cpp (files); no files here.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/sample/painter.h"
#include "builder/sample/world.h"

namespace vt::sample {

constexpr int kMaterialStep = 2;  // imagery texels per materials texel

// `rows` rows of imagery and what lies under them; all rows tightly packed.
struct Band {
  std::int64_t rows = 0;
  std::vector<std::uint8_t> rgb;       // size x rows x 3
  std::vector<std::uint8_t> material;  // size / 2 x rows / 2
  std::vector<float> height_m;         // size / 4 x rows / 4
};

struct Light {
  Position position;       // metres from the centre
  float height_m;          // above ground
  float red, green, blue;  // linear, the largest is 1
  float power_w;
};

[[nodiscard]] inline std::int64_t band_count(std::int64_t size) { return (size + kSquare - 1) / kSquare; }

// Band `index`, counted from the north, of the scene that is `size` (a multiple of 8) texels wide and high.
// Reuses `band`'s memory.
void paint_band(const World& world, std::int64_t size, std::int64_t index, Band& band);

// Street lamps, porch lights and flood lights inside the scene, always in the same order.
[[nodiscard]] std::vector<Light> lights_of(const World& world, std::int64_t size);

}  // namespace vt::sample
