// Prediction before compression: a tile's samples become differences from what their neighbours foretell,
// sorted into planes of bytes that an entropy coder shortens well. Reversible to the bit.
// schemas/tile-store.md defines predictors and planes; prediction*.cpp own them alone, the compressor behind
// is codec.cpp's. Pure functions, any thread; the bytes are the same on every CPU.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "store/texel_format.h"

namespace vt::store {

// Numbers are on disk.
enum class Predictor : std::uint8_t {
  kNone = 0,
  kLeft = 1,
  kUp = 2,
  kAverage = 3,   // of left and up, rounded up
  kGradient = 4,  // left + up - corner
  kMedian = 5,    // of left, up and gradient
};
inline constexpr std::size_t kPredictorCount = 6;

// How samples lie in a tile's payload: rows of texels from the north, channels interleaved.
struct TileShape {
  enum class Samples : std::uint8_t {
    kOpaque,  // bytes that no neighbour foretells: blocks, hashes
    kUint8,
    kUint16,
    kFloat16,
    kFloat32,
  };
  Samples samples = Samples::kOpaque;
  std::size_t width = 0;  // texels
  std::size_t height = 0;
  std::size_t channels = 0;  // 1 to 4

  [[nodiscard]] bool is_predictable() const { return samples != Samples::kOpaque; }
  [[nodiscard]] std::size_t sample_bytes() const {
    switch (samples) {
      case Samples::kOpaque:
      case Samples::kUint8:
        return 1;
      case Samples::kUint16:
      case Samples::kFloat16:
        return 2;
      case Samples::kFloat32:
        return 4;
    }
    return 1;
  }
  // The bytes of one plane, of which a channel has sample_bytes().
  [[nodiscard]] std::size_t plane_bytes() const { return width * height; }
  [[nodiscard]] std::size_t planes() const { return channels * sample_bytes(); }
  // The bytes of the payload, when it is predictable.
  [[nodiscard]] std::size_t raw_bytes() const { return planes() * plane_bytes(); }
};
// The shape of a square tile, `edge_texels` a side.
[[nodiscard]] TileShape tile_shape(TexelFormat format, std::size_t edge_texels);

struct Prediction {
  bool subtracts_green = false;  // only of three or four channels of bytes: the first and third are coded as differences from the second
  std::array<Predictor, 4> predictors = {};  // one a channel; kNone for those that the tile does not have
  auto operator<=>(const Prediction&) const = default;
};

// What is likely to code this tile in the fewest bytes, from a sample of its rows. `raw` is shape.raw_bytes()
// of a predictable shape.
[[nodiscard]] Prediction choose_prediction(std::span<const std::byte> raw, const TileShape& shape);

// `raw` and `planes` are both shape.raw_bytes() of a predictable shape, and do not overlap.
void split_into_residuals(std::span<const std::byte> raw, const TileShape& shape, const Prediction& prediction,
                          std::span<std::byte> planes);
void join_residuals(std::span<const std::byte> planes, const TileShape& shape, const Prediction& prediction, std::span<std::byte> raw);

}  // namespace vt::store
