#include "store/prediction.h"

#include <bit>
#include <cassert>
#include <utility>
#include <vector>

#include "store/bytes.h"
#include "store/predictor_rules.h"

// Plain loops that the compiler turns into vector instructions, once for every x86-64 and once for those with AVX2; the loader of the C
// library picks one when the program starts. (Before the thread sanitizer has started, which therefore has only the first.)
#if defined(__SANITIZE_THREAD__)
#define VT_HAS_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define VT_HAS_THREAD_SANITIZER 1
#endif
#endif
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(VT_HAS_THREAD_SANITIZER)
#define VT_VECTOR_LOOPS __attribute__((target_clones("avx2", "default")))
#else
#define VT_VECTOR_LOOPS
#endif

namespace vt::store {
namespace {

using Byte = std::uint8_t;

const Byte* bytes_of(std::span<const std::byte> bytes) { return reinterpret_cast<const Byte*>(bytes.data()); }
Byte* bytes_of(std::span<std::byte> bytes) { return reinterpret_cast<Byte*>(bytes.data()); }

// Working memory of one thread, kept from tile to tile.
template <class T>
T* working_rows(std::size_t count) {
  thread_local std::vector<T> rows;
  if (rows.size() < count) rows.resize(count);
  return rows.data();
}

// ---- Rows, whatever a value is ----

// Values 1 to `count` - 1 of a row that has one above it.
template <class T, class Rule>
void subtract_rule(const Rule& rule, const T* __restrict above, const T* __restrict now, T* __restrict out, std::size_t count) {
  for (std::size_t x = 1; x < count; ++x) out[x] = minus(now[x], rule(now[x - 1], above[x], above[x - 1]));
}

// What lies outside the tile is taken for the neighbour that does not: in the top row all three are the left one, in the first column all
// three are the upper one. The very first value has no neighbour, and stays as it is.
template <class T>
void subtract_row(Predictor predictor, const T* above, const T* now, T* out, std::size_t count) {
  with_rule(predictor, [&](const auto& rule) {
    if (above != nullptr) {
      out[0] = minus(now[0], rule(above[0], above[0], above[0]));
      return subtract_rule(rule, above, now, out, count);
    }
    out[0] = now[0];
    for (std::size_t x = 1; x < count; ++x) out[x] = minus(now[x], rule(now[x - 1], now[x - 1], now[x - 1]));
  });
}

// The other way. `Access` loads and stores the value at a place of a row.
template <class Access, class Rule, class Row>
void add_row(const Rule& rule, const Row* above, const Row* residuals, Row* now, std::size_t count) {
  using T = typename Access::Value;
  T left = Access::load(residuals, 0);
  if (above == nullptr) {
    Access::store(now, 0, left);
    for (std::size_t x = 1; x < count; ++x) {
      left = plus(Access::load(residuals, x), rule(left, left, left));
      Access::store(now, x, left);
    }
    return;
  }
  T corner = Access::load(above, 0);
  left = plus(left, rule(corner, corner, corner));
  Access::store(now, 0, left);
  for (std::size_t x = 1; x < count; ++x) {
    const T up = Access::load(above, x);
    left = plus(Access::load(residuals, x), rule(left, up, corner));
    Access::store(now, x, left);
    corner = up;
  }
}

// ---- Bytes ----

struct ByteRows {
  std::array<Byte*, 4> rows = {};
};
ByteRows byte_rows(Byte* first, std::size_t channels, std::size_t width) {
  ByteRows rows;
  for (std::size_t c = 0; c < channels; ++c) rows.rows[c] = first + c * width;
  return rows;
}

// Interleaved texels into a row a channel. The difference from green is moved by 128, so that the usual small ones do not jump between 0
// and 255, which no predictor foretells.
VT_VECTOR_LOOPS void separate_rgb(const Byte* __restrict texels, std::size_t width, Byte* __restrict r, Byte* __restrict g,
                                  Byte* __restrict b) {
  for (std::size_t x = 0; x < width; ++x) {
    r[x] = texels[3 * x];
    g[x] = texels[3 * x + 1];
    b[x] = texels[3 * x + 2];
  }
}
VT_VECTOR_LOOPS void separate_rgba(const Byte* __restrict texels, std::size_t width, Byte* __restrict r, Byte* __restrict g,
                                   Byte* __restrict b, Byte* __restrict a) {
  for (std::size_t x = 0; x < width; ++x) {
    r[x] = texels[4 * x];
    g[x] = texels[4 * x + 1];
    b[x] = texels[4 * x + 2];
    a[x] = texels[4 * x + 3];
  }
}
VT_VECTOR_LOOPS void subtract_green(const Byte* __restrict green, std::size_t width, Byte* __restrict row) {
  for (std::size_t x = 0; x < width; ++x) row[x] = static_cast<Byte>(row[x] - green[x] + 128);
}
void separate(const Byte* texels, std::size_t channels, std::size_t width, const ByteRows& out) {
  if (channels == 3) return separate_rgb(texels, width, out.rows[0], out.rows[1], out.rows[2]);
  if (channels == 4) return separate_rgba(texels, width, out.rows[0], out.rows[1], out.rows[2], out.rows[3]);
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t x = 0; x < width; ++x) out.rows[c][x] = texels[channels * x + c];
}

void split_bytes(const Byte* texels, const TileShape& shape, const Prediction& prediction, Byte* planes) {
  const std::size_t row_bytes = shape.channels * shape.width;
  Byte* const rows = working_rows<Byte>(2 * row_bytes);
  ByteRows above;
  ByteRows now = byte_rows(rows, shape.channels, shape.width);
  ByteRows spare = byte_rows(rows + row_bytes, shape.channels, shape.width);
  for (std::size_t y = 0; y < shape.height; ++y) {
    separate(texels + y * row_bytes, shape.channels, shape.width, now);
    if (prediction.subtracts_green)
      for (const std::size_t c : {0, 2}) subtract_green(now.rows[1], shape.width, now.rows[c]);
    for (std::size_t c = 0; c < shape.channels; ++c)
      subtract_row(prediction.predictors[c], above.rows[c], now.rows[c], planes + c * shape.plane_bytes() + y * shape.width, shape.width);
    above = std::exchange(now, y == 0 ? spare : above);
  }
}

struct PixelAccess {
  using Value = Pixel;
  static Pixel load(const Byte* row, std::size_t x) { return Pixel::load(row + 4 * x); }
  static void store(Byte* row, std::size_t x, Pixel pixel) { pixel.store(row + 4 * x); }
};

// Channels with predictors of their own: all are computed, and masks choose.
class PredictMixed {
 public:
  explicit PredictMixed(const std::array<Predictor, 4>& predictors) {
    for (std::size_t p = 0; p < kPredictorCount; ++p) {
      std::array<Byte, 4> mask = {};
      for (std::size_t c = 0; c < 4; ++c) mask[c] = static_cast<std::size_t>(predictors[c]) == p ? 0xFF : 0;
      masks_[p] = Pixel::load(mask.data());
    }
  }
  [[nodiscard]] Pixel operator()(Pixel left, Pixel up, Pixel corner) const {
    // What does not wait for the left neighbour comes first.
    const Pixel early = up & mask(Predictor::kUp);
    const Pixel linear = (left & mask(Predictor::kLeft)) | (average(left, up) & mask(Predictor::kAverage));
    const Pixel curved =
        (PredictGradient()(left, up, corner) & mask(Predictor::kGradient)) | (PredictMedian()(left, up, corner) & mask(Predictor::kMedian));
    return early | linear | curved;
  }

 private:
  [[nodiscard]] Pixel mask(Predictor predictor) const { return masks_[static_cast<std::size_t>(predictor)]; }
  std::array<Pixel, kPredictorCount> masks_;
};

// A row a channel into pixels of four bytes, and from pixels into texels.
VT_VECTOR_LOOPS void gather_pixels(const ByteRows& rows, std::size_t channels, std::size_t width, Byte* __restrict out) {
  const Byte* const r = rows.rows[0];
  const Byte* const g = channels > 1 ? rows.rows[1] : r;
  const Byte* const b = channels > 2 ? rows.rows[2] : r;
  const Byte* const a = channels > 3 ? rows.rows[3] : r;
  for (std::size_t x = 0; x < width; ++x) {
    out[4 * x] = r[x];
    out[4 * x + 1] = g[x];
    out[4 * x + 2] = b[x];
    out[4 * x + 3] = a[x];
  }
}
VT_VECTOR_LOOPS void add_green(const Byte* __restrict pixels, std::size_t width, Byte* __restrict out) {
  for (std::size_t x = 0; x < width; ++x) {
    const Byte green = static_cast<Byte>(pixels[4 * x + 1] - 128);
    out[4 * x] = static_cast<Byte>(pixels[4 * x] + green);
    out[4 * x + 1] = pixels[4 * x + 1];
    out[4 * x + 2] = static_cast<Byte>(pixels[4 * x + 2] + green);
    out[4 * x + 3] = pixels[4 * x + 3];
  }
}
VT_VECTOR_LOOPS void write_rgb(const Byte* __restrict pixels, std::size_t width, Byte* __restrict texels) {
  for (std::size_t x = 0; x < width; ++x) {
    texels[3 * x] = pixels[4 * x];
    texels[3 * x + 1] = pixels[4 * x + 1];
    texels[3 * x + 2] = pixels[4 * x + 2];
  }
}
void write_texels(const Byte* pixels, std::size_t channels, std::size_t width, Byte* texels) {
  if (channels == 3) return write_rgb(pixels, width, texels);
  for (std::size_t x = 0; x < width; ++x) std::memcpy(texels + channels * x, pixels + 4 * x, channels);
}

template <class Rule>
void join_bytes(const Rule& rule, const Byte* planes, const TileShape& shape, bool subtracts_green, Byte* texels) {
  const std::size_t pixel_row_bytes = 4 * shape.width;
  Byte* const residuals = working_rows<Byte>(3 * pixel_row_bytes);
  Byte* now = residuals + pixel_row_bytes;
  Byte* spare = now + pixel_row_bytes;
  const Byte* above = nullptr;
  for (std::size_t y = 0; y < shape.height; ++y) {
    ByteRows rows;
    for (std::size_t c = 0; c < shape.channels; ++c) rows.rows[c] = const_cast<Byte*>(planes) + c * shape.plane_bytes() + y * shape.width;
    gather_pixels(rows, shape.channels, shape.width, residuals);
    add_row<PixelAccess>(rule, above, residuals, now, shape.width);
    if (subtracts_green) add_green(now, shape.width, residuals);
    write_texels(subtracts_green ? residuals : now, shape.channels, shape.width, texels + y * shape.channels * shape.width);
    above = now;
    std::swap(now, spare);
  }
}

// ---- Floats, as integers in the same order ----

struct WordAccess {
  using Value = std::uint32_t;
  static std::uint32_t load(const std::uint32_t* row, std::size_t x) { return row[x]; }
  static void store(std::uint32_t* row, std::size_t x, std::uint32_t value) { row[x] = value; }
};

// All ones when the top bit is set, else zero.
constexpr std::uint32_t sign_mask(std::uint32_t word) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(word) >> 31); }

// An order-preserving map of the bits of a float, NaNs included, and its inverse.
constexpr std::uint32_t ordered_from_bits(std::uint32_t bits) { return bits ^ (sign_mask(bits) | 0x80000000U); }
constexpr std::uint32_t bits_from_ordered(std::uint32_t word) { return word ^ (~sign_mask(word) | 0x80000000U); }
// 0, -1, 1, -2 ... become 0, 1, 2, 3 ..., so that small differences of either sign have zeros in front.
constexpr std::uint32_t folded(std::uint32_t difference) { return (difference << 1) ^ sign_mask(difference); }
constexpr std::uint32_t unfolded(std::uint32_t word) { return (word >> 1) ^ (0U - (word & 1U)); }

std::uint32_t load_word(const Byte* bytes) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return detail::little_endian(word);
}

void separate_words(const Byte* texels, std::size_t channels, std::size_t channel, std::size_t width, std::uint32_t* out) {
  for (std::size_t x = 0; x < width; ++x) out[x] = ordered_from_bits(load_word(texels + 4 * (channels * x + channel)));
}

// Words to and from rows of their bytes, the most significant first; the rows lie `pitch` bytes apart.
VT_VECTOR_LOOPS void write_byte_rows(const std::uint32_t* __restrict differences, std::size_t width, std::size_t pitch,
                                     Byte* __restrict rows) {
  for (std::size_t plane = 0; plane < 4; ++plane) {
    const int shift = 24 - 8 * static_cast<int>(plane);
    Byte* __restrict out = rows + plane * pitch;
    for (std::size_t x = 0; x < width; ++x) out[x] = static_cast<Byte>(folded(differences[x]) >> shift);
  }
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

void split_floats(const Byte* texels, const TileShape& shape, const Prediction& prediction, Byte* planes) {
  const std::size_t plane_bytes = shape.plane_bytes();
  std::uint32_t* const residuals = working_rows<std::uint32_t>(3 * shape.width);
  for (std::size_t c = 0; c < shape.channels; ++c) {
    std::uint32_t* now = residuals + shape.width;
    std::uint32_t* spare = now + shape.width;
    const std::uint32_t* above = nullptr;
    for (std::size_t y = 0; y < shape.height; ++y) {
      separate_words(texels + y * 4 * shape.channels * shape.width, shape.channels, c, shape.width, now);
      subtract_row(prediction.predictors[c], above, now, residuals, shape.width);
      write_byte_rows(residuals, shape.width, plane_bytes, planes + 4 * c * plane_bytes + y * shape.width);
      above = now;
      std::swap(now, spare);
    }
  }
}

void join_floats(const Byte* planes, const TileShape& shape, const Prediction& prediction, Byte* texels) {
  const std::size_t plane_bytes = shape.plane_bytes();
  std::uint32_t* const residuals = working_rows<std::uint32_t>(3 * shape.width);
  for (std::size_t c = 0; c < shape.channels; ++c) {
    std::uint32_t* now = residuals + shape.width;
    std::uint32_t* spare = now + shape.width;
    const std::uint32_t* above = nullptr;
    for (std::size_t y = 0; y < shape.height; ++y) {
      read_byte_rows(planes + 4 * c * plane_bytes + y * shape.width, shape.width, plane_bytes, residuals);
      with_rule(prediction.predictors[c], [&](const auto& rule) { add_row<WordAccess>(rule, above, residuals, now, shape.width); });
      Byte* const out = texels + 4 * (y * shape.channels * shape.width + c);
      for (std::size_t x = 0; x < shape.width; ++x) {
        const std::uint32_t bits = detail::little_endian(bits_from_ordered(now[x]));
        std::memcpy(out + 4 * shape.channels * x, &bits, sizeof bits);
      }
      above = now;
      std::swap(now, spare);
    }
  }
}

// ---- Choosing, by the entropy of residuals on a sample of rows ----

constexpr std::size_t kSampledRows = 8;
constexpr std::size_t kSampledColumns = 256;
constexpr std::size_t kMaxSampled = kSampledRows * kSampledColumns;

// Integers, so that every machine makes the same choice.
constexpr int kLogFraction = 16;
constexpr std::uint32_t log2_fixed(std::uint32_t value) {
  const int whole = std::bit_width(value) - 1;
  std::uint64_t mantissa = std::uint64_t{value} << (31 - whole);  // 1 to 2, with 31 bits behind the point
  std::uint32_t log = static_cast<std::uint32_t>(whole) << kLogFraction;
  for (int bit = kLogFraction - 1; bit >= 0; --bit) {
    mantissa = (mantissa * mantissa) >> 31;
    if (mantissa >> 32 == 0) continue;
    mantissa >>= 1;
    log |= 1U << bit;
  }
  return log;
}
constexpr auto kCountTimesLog = [] {
  std::array<std::uint32_t, kMaxSampled + 1> table = {};
  for (std::uint32_t count = 1; count <= kMaxSampled; ++count) table[count] = count * log2_fixed(count);
  return table;
}();

struct Histogram {
  // Two tables, so that one of two equal bytes in a row need not wait for the other.
  std::array<std::array<std::uint16_t, 256>, 2> counts = {};

  void add(const Byte* bytes, std::size_t count) {
    for (std::size_t i = 0; i + 1 < count; i += 2) {
      ++counts[0][bytes[i]];
      ++counts[1][bytes[i + 1]];
    }
    if (count % 2 != 0) ++counts[0][bytes[count - 1]];
  }
  // n log2 n less the sum of c log2 c: what an ideal code would take.
  [[nodiscard]] std::uint64_t bits(std::size_t total) const {
    std::uint64_t saved = 0;
    for (std::size_t value = 0; value < 256; ++value) saved += kCountTimesLog[counts[0][value] + counts[1][value]];
    return kCountTimesLog[total] - saved;
  }
};

// What one channel would cost with each predictor.
using Costs = std::array<std::uint64_t, kPredictorCount>;

// Those that were the best of some tile of the rasters they were compared on: photographs from 0.1 m to 500 m a texel, elevation models.
// (Paeth's was never better than the median.)
constexpr std::array kByteCandidates = {Predictor::kNone, Predictor::kLeft, Predictor::kUp, Predictor::kAverage, Predictor::kMedian};
constexpr std::array kFloatCandidates = {Predictor::kLeft, Predictor::kUp, Predictor::kAverage, Predictor::kGradient, Predictor::kMedian};

std::size_t index_of(Predictor predictor) { return static_cast<std::size_t>(predictor); }

struct SampledRow {
  std::size_t x = 0;
  std::size_t y = 0;  // at least 1
};
// Evenly down the tile, and from its left side to its right.
std::size_t sampled_rows(const TileShape& shape) { return std::min(kSampledRows, shape.height - 1); }
std::size_t sampled_columns(const TileShape& shape) { return std::min(kSampledColumns, shape.width); }
SampledRow sampled_row(const TileShape& shape, std::size_t i) {
  const std::size_t rows = sampled_rows(shape);
  return {.x = rows > 1 ? i * (shape.width - sampled_columns(shape)) / (rows - 1) : 0,
          .y = 1 + (2 * i + 1) * (shape.height - 1) / (2 * rows)};
}

// The best predictor of each channel, but one for all where that is nearly as good, because it decodes faster.
std::array<Predictor, 4> cheapest(std::span<const Costs> channels, std::span<const Predictor> candidates, std::uint64_t& cost) {
  std::array<Predictor, 4> each = {};
  std::uint64_t each_cost = 0;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    each[c] = *std::min_element(candidates.begin(), candidates.end(),
                                [&](Predictor a, Predictor b) { return channels[c][index_of(a)] < channels[c][index_of(b)]; });
    each_cost += channels[c][index_of(each[c])];
  }
  const auto cost_of_one = [&](Predictor predictor) {
    std::uint64_t sum = 0;
    for (const Costs& costs : channels) sum += costs[index_of(predictor)];
    return sum;
  };
  const Predictor one =
      *std::min_element(candidates.begin(), candidates.end(), [&](Predictor a, Predictor b) { return cost_of_one(a) < cost_of_one(b); });
  cost = cost_of_one(one);
  if (each_cost < cost - cost / 64) {
    cost = each_cost;
    return each;
  }
  std::array<Predictor, 4> all = {};
  std::fill_n(all.begin(), channels.size(), one);
  return all;
}

Prediction choose_for_bytes(const Byte* texels, const TileShape& shape) {
  // The channels as they are, then the first and the third less green.
  constexpr std::size_t kMaxStreams = 6;
  const bool may_subtract = shape.channels >= 3;
  const std::size_t streams = may_subtract ? shape.channels + 2 : shape.channels;
  const std::size_t columns = sampled_columns(shape);
  std::array<std::array<Histogram, kPredictorCount>, kMaxStreams> histograms = {};
  std::array<std::array<Byte, kSampledColumns>, kMaxStreams> above_rows;
  std::array<std::array<Byte, kSampledColumns>, kMaxStreams> now_rows;
  std::array<Byte, kSampledColumns> residuals;

  const auto load = [&](std::size_t x, std::size_t y, auto& rows) {
    ByteRows out;
    for (std::size_t c = 0; c < shape.channels; ++c) out.rows[c] = rows[c].data();
    separate(texels + (y * shape.width + x) * shape.channels, shape.channels, columns, out);
    if (!may_subtract) return;
    for (const std::size_t c : {0, 2}) {
      auto& difference = rows[shape.channels + c / 2];
      difference = rows[c];
      subtract_green(rows[1].data(), columns, difference.data());
    }
  };
  for (std::size_t row = 0; row < sampled_rows(shape); ++row) {
    const SampledRow at = sampled_row(shape, row);
    load(at.x, at.y - 1, above_rows);
    load(at.x, at.y, now_rows);
    for (std::size_t s = 0; s < streams; ++s) {
      for (const Predictor predictor : kByteCandidates) {
        with_rule(predictor,
                  [&](const auto& rule) { subtract_rule(rule, above_rows[s].data(), now_rows[s].data(), residuals.data(), columns); });
        histograms[s][index_of(predictor)].add(residuals.data() + 1, columns - 1);
      }
    }
  }

  const std::size_t total = sampled_rows(shape) * (columns - 1);
  std::array<Costs, kMaxStreams> costs = {};
  for (std::size_t s = 0; s < streams; ++s)
    for (const Predictor predictor : kByteCandidates) costs[s][index_of(predictor)] = histograms[s][index_of(predictor)].bits(total);

  std::uint64_t plain_cost = 0;
  const Prediction plain{.subtracts_green = false,
                         .predictors = cheapest(std::span(costs).first(shape.channels), kByteCandidates, plain_cost)};
  if (!may_subtract) return plain;
  costs[0] = costs[shape.channels];
  costs[2] = costs[shape.channels + 1];
  std::uint64_t green_cost = 0;
  const Prediction green{.subtracts_green = true,
                         .predictors = cheapest(std::span(costs).first(shape.channels), kByteCandidates, green_cost)};
  return green_cost < plain_cost ? green : plain;
}

Prediction choose_for_floats(const Byte* texels, const TileShape& shape) {
  const std::size_t columns = sampled_columns(shape);
  std::array<std::uint32_t, kSampledColumns> above;
  std::array<std::uint32_t, kSampledColumns> now;
  std::array<std::uint32_t, kSampledColumns> residuals;
  std::array<Byte, 4 * kSampledColumns> bytes;
  const std::size_t total = sampled_rows(shape) * (columns - 1);

  Prediction prediction;
  for (std::size_t c = 0; c < shape.channels; ++c) {
    std::array<std::array<Histogram, 4>, kPredictorCount> histograms = {};
    for (std::size_t row = 0; row < sampled_rows(shape); ++row) {
      const SampledRow at = sampled_row(shape, row);
      const auto load = [&](std::size_t y, auto& out) {
        separate_words(texels + 4 * (y * shape.width + at.x) * shape.channels, shape.channels, c, columns, out.data());
      };
      load(at.y - 1, above);
      load(at.y, now);
      for (const Predictor predictor : kFloatCandidates) {
        with_rule(predictor, [&](const auto& rule) { subtract_rule(rule, above.data(), now.data(), residuals.data(), columns); });
        write_byte_rows(residuals.data() + 1, columns - 1, kSampledColumns, bytes.data());
        for (std::size_t plane = 0; plane < 4; ++plane)
          histograms[index_of(predictor)][plane].add(bytes.data() + plane * kSampledColumns, columns - 1);
      }
    }
    Costs costs = {};
    for (const Predictor predictor : kFloatCandidates)
      for (const Histogram& histogram : histograms[index_of(predictor)]) costs[index_of(predictor)] += histogram.bits(total);
    std::uint64_t cost = 0;
    prediction.predictors[c] = cheapest({&costs, 1}, kFloatCandidates, cost)[0];
  }
  return prediction;
}

}  // namespace

TileShape tile_shape(TexelFormat format, std::size_t edge_texels) {
  TileShape shape{.width = edge_texels, .height = edge_texels, .channels = format_info(format).channels};
  switch (format_info(format).samples) {
    case SampleKind::kUnorm8:
      shape.samples = TileShape::Samples::kUint8;
      break;
    case SampleKind::kFloat:
      shape.samples = TileShape::Samples::kFloat32;
      break;
    case SampleKind::kUnorm16:
    case SampleKind::kHalf:
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      break;
  }
  return shape;
}

Prediction choose_prediction(std::span<const std::byte> raw, const TileShape& shape) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes());
  if (shape.width < 2 || shape.height < 2) {
    // Nothing to sample, and next to nothing to gain.
    Prediction prediction;
    std::fill_n(prediction.predictors.begin(), shape.channels, Predictor::kAverage);
    return prediction;
  }
  return shape.samples == TileShape::Samples::kUint8 ? choose_for_bytes(bytes_of(raw), shape) : choose_for_floats(bytes_of(raw), shape);
}

void split_into_residuals(std::span<const std::byte> raw, const TileShape& shape, const Prediction& prediction,
                          std::span<std::byte> planes) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes() && planes.size() == shape.raw_bytes());
  if (raw.empty()) return;
  if (shape.samples == TileShape::Samples::kUint8) return split_bytes(bytes_of(raw), shape, prediction, bytes_of(planes));
  split_floats(bytes_of(raw), shape, prediction, bytes_of(planes));
}

void join_residuals(std::span<const std::byte> planes, const TileShape& shape, const Prediction& prediction, std::span<std::byte> raw) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes() && planes.size() == shape.raw_bytes());
  if (raw.empty()) return;
  if (shape.samples == TileShape::Samples::kFloat32) return join_floats(bytes_of(planes), shape, prediction, bytes_of(raw));
  const auto join = [&](const auto& rule) { join_bytes(rule, bytes_of(planes), shape, prediction.subtracts_green, bytes_of(raw)); };
  const Predictor first = prediction.predictors[0];
  const bool is_one_for_all =
      std::all_of(prediction.predictors.begin(), prediction.predictors.begin() + static_cast<std::ptrdiff_t>(shape.channels),
                  [&](Predictor predictor) { return predictor == first; });
  if (is_one_for_all) return with_rule(first, join);
  join(PredictMixed(prediction.predictors));
}

}  // namespace vt::store
