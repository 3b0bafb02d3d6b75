#include "store/codec/prediction_words.h"

#include <cstring>
#include <type_traits>
#include <utility>

#include "store/codec/prediction_rows.h"
#include "store/io/bytes.h"

namespace vt::store {
namespace {

template <class Word>
struct WordAccess {
  using Value = Word;
  static Word load(const Word* row, std::size_t x) { return row[x]; }
  static void store(Word* row, std::size_t x, Word value) { row[x] = value; }
};

template <class Word>
constexpr Word kTopBit = static_cast<Word>(Word{1} << (8 * sizeof(Word) - 1));

// All ones when the top bit is set, else zero.
template <class Word>
constexpr Word sign_mask(Word word) {
  return static_cast<Word>(static_cast<std::make_signed_t<Word>>(word) >> (8 * sizeof(Word) - 1));
}

// An order-preserving map of the bits of a float, NaNs included, and its inverse.
template <class Word>
constexpr Word ordered_from_bits(Word bits) {
  return static_cast<Word>(bits ^ (sign_mask(bits) | kTopBit<Word>));
}
template <class Word>
constexpr Word bits_from_ordered(Word word) {
  return static_cast<Word>(word ^ (static_cast<Word>(~sign_mask(word)) | kTopBit<Word>));
}
// 0, -1, 1, -2 ... become 0, 1, 2, 3 ..., so that small differences of either sign have zeros in front.
template <class Word>
constexpr Word folded(Word difference) {
  return static_cast<Word>(static_cast<Word>(difference << 1) ^ sign_mask(difference));
}
template <class Word>
constexpr Word unfolded(Word word) {
  return static_cast<Word>((word >> 1) ^ static_cast<Word>(0U - (word & 1U)));
}

template <class Word>
Word load_word(const Byte* bytes) {
  Word word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return detail::little_endian(word);
}
template <class Word>
void store_word(Word word, Byte* bytes) {
  word = detail::little_endian(word);
  std::memcpy(bytes, &word, sizeof word);
}

VT_VECTOR_LOOPS void write_two_rows(const std::uint16_t* __restrict differences, std::size_t width, Byte* __restrict high,
                                    Byte* __restrict low) {
  for (std::size_t x = 0; x < width; ++x) high[x] = static_cast<Byte>(folded(differences[x]) >> 8);
  for (std::size_t x = 0; x < width; ++x) low[x] = static_cast<Byte>(folded(differences[x]));
}
VT_VECTOR_LOOPS void write_four_rows(const std::uint32_t* __restrict differences, std::size_t width, std::size_t pitch,
                                     Byte* __restrict rows) {
  for (std::size_t plane = 0; plane < 4; ++plane) {
    const int shift = 24 - 8 * static_cast<int>(plane);
    Byte* __restrict out = rows + plane * pitch;
    for (std::size_t x = 0; x < width; ++x) out[x] = static_cast<Byte>(folded(differences[x]) >> shift);
  }
}
VT_VECTOR_LOOPS void read_byte_rows(const Byte* __restrict rows, std::size_t width, std::size_t pitch,
                                    std::uint16_t* __restrict differences) {
  const Byte* const low = rows + pitch;
  for (std::size_t x = 0; x < width; ++x)
    differences[x] = unfolded(static_cast<std::uint16_t>(static_cast<unsigned>(rows[x]) << 8 | low[x]));
}
VT_VECTOR_LOOPS void read_byte_rows(const Byte* __restrict rows, std::size_t width, std::size_t pitch,
                                    std::uint32_t* __restrict differences) {
  const Byte* const second = rows + pitch;
  const Byte* const third = second + pitch;
  const Byte* const fourth = third + pitch;
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint32_t high = (std::uint32_t{rows[x]} << 24) | (std::uint32_t{second[x]} << 16);
    differences[x] = unfolded(high | (std::uint32_t{third[x]} << 8) | std::uint32_t{fourth[x]});
  }
}

}  // namespace

template <std::unsigned_integral Word>
void separate_words(WordOrder order, const Byte* texels, std::size_t channels, std::size_t channel, std::size_t width, Word* out) {
  const Byte* const first = texels + sizeof(Word) * channel;
  const std::size_t step = sizeof(Word) * channels;
  if (order == WordOrder::kInteger) {
    for (std::size_t x = 0; x < width; ++x) out[x] = load_word<Word>(first + step * x);
  } else {
    for (std::size_t x = 0; x < width; ++x) out[x] = ordered_from_bits(load_word<Word>(first + step * x));
  }
}

void write_byte_rows(const std::uint16_t* differences, std::size_t width, std::size_t pitch, Byte* rows) {
  write_two_rows(differences, width, rows, rows + pitch);
}
void write_byte_rows(const std::uint32_t* differences, std::size_t width, std::size_t pitch, Byte* rows) {
  write_four_rows(differences, width, pitch, rows);
}

template <std::unsigned_integral Word>
void split_words(WordOrder order, const Byte* texels, const TileShape& shape, const Prediction& prediction, Byte* planes) {
  const std::size_t plane_bytes = shape.plane_bytes();
  Word* const residuals = working_rows<Word>(3 * shape.width);
  for (std::size_t c = 0; c < shape.channels; ++c) {
    Word* now = residuals + shape.width;
    Word* spare = now + shape.width;
    const Word* above = nullptr;
    for (std::size_t y = 0; y < shape.height; ++y) {
      separate_words(order, texels + y * sizeof(Word) * shape.channels * shape.width, shape.channels, c, shape.width, now);
      subtract_row(prediction.predictors[c], above, now, residuals, shape.width);
      write_byte_rows(residuals, shape.width, plane_bytes, planes + sizeof(Word) * c * plane_bytes + y * shape.width);
      above = now;
      std::swap(now, spare);
    }
  }
}

template <std::unsigned_integral Word>
void join_words(WordOrder order, const Byte* planes, const TileShape& shape, const Prediction& prediction, Byte* texels) {
  const std::size_t plane_bytes = shape.plane_bytes();
  const std::size_t step = sizeof(Word) * shape.channels;
  Word* const residuals = working_rows<Word>(3 * shape.width);
  for (std::size_t c = 0; c < shape.channels; ++c) {
    Word* now = residuals + shape.width;
    Word* spare = now + shape.width;
    const Word* above = nullptr;
    for (std::size_t y = 0; y < shape.height; ++y) {
      read_byte_rows(planes + sizeof(Word) * c * plane_bytes + y * shape.width, shape.width, plane_bytes, residuals);
      with_rule(prediction.predictors[c], [&](const auto& rule) { add_row<WordAccess<Word>>(rule, above, residuals, now, shape.width); });
      Byte* const out = texels + y * step * shape.width + sizeof(Word) * c;
      if (order == WordOrder::kInteger) {
        for (std::size_t x = 0; x < shape.width; ++x) store_word(now[x], out + step * x);
      } else {
        for (std::size_t x = 0; x < shape.width; ++x) store_word(bits_from_ordered(now[x]), out + step * x);
      }
      above = now;
      std::swap(now, spare);
    }
  }
}

template void separate_words(WordOrder, const Byte*, std::size_t, std::size_t, std::size_t, std::uint16_t*);
template void separate_words(WordOrder, const Byte*, std::size_t, std::size_t, std::size_t, std::uint32_t*);
template void split_words<std::uint16_t>(WordOrder, const Byte*, const TileShape&, const Prediction&, Byte*);
template void split_words<std::uint32_t>(WordOrder, const Byte*, const TileShape&, const Prediction&, Byte*);
template void join_words<std::uint16_t>(WordOrder, const Byte*, const TileShape&, const Prediction&, Byte*);
template void join_words<std::uint32_t>(WordOrder, const Byte*, const TileShape&, const Prediction&, Byte*);

}  // namespace vt::store
