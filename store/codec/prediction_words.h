// Prediction of tiles of 16- and 32-bit channels, integers or floats. Private to prediction*.cpp;
// prediction.h says what the arguments are.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "store/codec/prediction.h"

namespace vt::store {

// How the bits of a sample become a value: as they are, or in the order of the floats that they are, NaNs
// included.
enum class WordOrder : std::uint8_t { kInteger, kFloat };

// One channel of a row of interleaved texels, as values. `Word` is std::uint16_t or std::uint32_t.
template <std::unsigned_integral Word>
void separate_words(WordOrder order, const std::uint8_t* texels, std::size_t channels, std::size_t channel, std::size_t width, Word* out);
// Differences, folded, into rows of their bytes, the most significant first; the rows lie `pitch` bytes
// apart.
void write_byte_rows(const std::uint16_t* differences, std::size_t width, std::size_t pitch, std::uint8_t* rows);
void write_byte_rows(const std::uint32_t* differences, std::size_t width, std::size_t pitch, std::uint8_t* rows);

template <std::unsigned_integral Word>
void split_words(WordOrder order, const std::uint8_t* texels, const TileShape& shape, const Prediction& prediction, std::uint8_t* planes);
template <std::unsigned_integral Word>
void join_words(WordOrder order, const std::uint8_t* planes, const TileShape& shape, const Prediction& prediction, std::uint8_t* texels);

}  // namespace vt::store
