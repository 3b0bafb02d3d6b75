// Prediction of tiles of 8-bit channels. Private to prediction*.cpp; prediction.h says what the arguments
// are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "store/codec/prediction.h"

namespace vt::store {

// A row a channel; those that a tile does not have are null.
struct ByteRows {
  std::array<std::uint8_t*, 4> rows = {};
};
// Interleaved texels into a row a channel.
void separate(const std::uint8_t* texels, std::size_t channels, std::size_t width, const ByteRows& out);
// The difference from green is moved by 128, so that the usual small ones do not jump between 0 and 255,
// which no predictor foretells.
void subtract_green(const std::uint8_t* green, std::size_t width, std::uint8_t* row);

void split_bytes(const std::uint8_t* texels, const TileShape& shape, const Prediction& prediction, std::uint8_t* planes);
void join_bytes(const std::uint8_t* planes, const TileShape& shape, const Prediction& prediction, std::uint8_t* texels);

}  // namespace vt::store
