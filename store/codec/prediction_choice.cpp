#include "store/codec/prediction_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "store/codec/prediction_bytes.h"
#include "store/codec/prediction_rows.h"

namespace vt::store {
namespace {

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

// Those that were the best of some tile of the rasters they were compared on: photographs from 0.1 m to 500 m
// a texel, elevation models. (Paeth's was never better than the median.)
constexpr std::array kByteCandidates = {Predictor::kNone, Predictor::kLeft, Predictor::kUp, Predictor::kAverage, Predictor::kMedian};
constexpr std::array kWordCandidates = {Predictor::kLeft, Predictor::kUp, Predictor::kAverage, Predictor::kGradient, Predictor::kMedian};

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

// The best predictor of each channel, but one for all where that is nearly as good, because it decodes
// faster.
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

}  // namespace

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

template <std::unsigned_integral Word>
Prediction choose_for_words(WordOrder order, const Byte* texels, const TileShape& shape) {
  const std::size_t columns = sampled_columns(shape);
  std::array<Word, kSampledColumns> above;
  std::array<Word, kSampledColumns> now;
  std::array<Word, kSampledColumns> residuals;
  std::array<Byte, sizeof(Word) * kSampledColumns> bytes;
  const std::size_t total = sampled_rows(shape) * (columns - 1);

  Prediction prediction;
  for (std::size_t c = 0; c < shape.channels; ++c) {
    std::array<std::array<Histogram, sizeof(Word)>, kPredictorCount> histograms = {};
    for (std::size_t row = 0; row < sampled_rows(shape); ++row) {
      const SampledRow at = sampled_row(shape, row);
      const auto load = [&](std::size_t y, auto& out) {
        separate_words(order, texels + sizeof(Word) * (y * shape.width + at.x) * shape.channels, shape.channels, c, columns, out.data());
      };
      load(at.y - 1, above);
      load(at.y, now);
      for (const Predictor predictor : kWordCandidates) {
        with_rule(predictor, [&](const auto& rule) { subtract_rule(rule, above.data(), now.data(), residuals.data(), columns); });
        write_byte_rows(residuals.data() + 1, columns - 1, kSampledColumns, bytes.data());
        for (std::size_t plane = 0; plane < sizeof(Word); ++plane)
          histograms[index_of(predictor)][plane].add(bytes.data() + plane * kSampledColumns, columns - 1);
      }
    }
    Costs costs = {};
    for (const Predictor predictor : kWordCandidates)
      for (const Histogram& histogram : histograms[index_of(predictor)]) costs[index_of(predictor)] += histogram.bits(total);
    std::uint64_t cost = 0;
    prediction.predictors[c] = cheapest({&costs, 1}, kWordCandidates, cost)[0];
  }
  return prediction;
}

template Prediction choose_for_words<std::uint16_t>(WordOrder, const Byte*, const TileShape&);
template Prediction choose_for_words<std::uint32_t>(WordOrder, const Byte*, const TileShape&);

}  // namespace vt::store
