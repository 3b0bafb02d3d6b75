// Turns the sample world into samples: colour and class at the finest resolution, height at a quarter of it,
// one square at a time. Reads only `World`; a square does not know which other squares are painted, so any
// number of threads may paint at once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "builder/sample/world.h"

namespace vt::sample {

constexpr double kTexelMetres = 0.5;  // of the imagery
constexpr int kSquare = 256;          // texels along one side of a painted square
constexpr int kHeightStep = 4;        // imagery texels per elevation texel
constexpr int kHeightSquare = kSquare / kHeightStep;
constexpr float kVoid = -9999.0F;

struct Square {
  std::array<std::uint8_t, std::size_t{kSquare} * kSquare * 3> rgb;
  std::array<Material, std::size_t{kSquare} * kSquare> material;
  std::array<float, std::size_t{kHeightSquare} * kHeightSquare> height_m;  // kVoid where the surface was not measured
};

class Painter {
 public:
  explicit Painter(const World& world);
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  // Paints the square whose north-west texel is `column` texels east and `row` texels south of the scene's
  // centre; both are multiples of 4. A painter keeps scratch memory (about 6 MiB), so each thread needs its
  // own.
  void paint(std::int64_t column, std::int64_t row, Square& out);

 private:
  struct Scratch;
  const World& world_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace vt::sample
