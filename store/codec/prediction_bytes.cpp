#include "store/codec/prediction_bytes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "store/codec/prediction_rows.h"

namespace vt::store {
namespace {

ByteRows byte_rows(Byte* first, std::size_t channels, std::size_t width) {
  ByteRows rows;
  for (std::size_t c = 0; c < channels; ++c) rows.rows[c] = first + c * width;
  return rows;
}

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
VT_VECTOR_LOOPS void subtract_green_rows(const Byte* __restrict green, std::size_t width, Byte* __restrict row) {
  for (std::size_t x = 0; x < width; ++x) row[x] = static_cast<Byte>(row[x] - green[x] + 128);
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
void join_by_rule(const Rule& rule, const Byte* planes, const TileShape& shape, bool subtracts_green, Byte* texels) {
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

}  // namespace

void separate(const Byte* texels, std::size_t channels, std::size_t width, const ByteRows& out) {
  if (channels == 3) return separate_rgb(texels, width, out.rows[0], out.rows[1], out.rows[2]);
  if (channels == 4) return separate_rgba(texels, width, out.rows[0], out.rows[1], out.rows[2], out.rows[3]);
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t x = 0; x < width; ++x) out.rows[c][x] = texels[channels * x + c];
}

void subtract_green(const Byte* green, std::size_t width, Byte* row) { subtract_green_rows(green, width, row); }

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

void join_bytes(const Byte* planes, const TileShape& shape, const Prediction& prediction, Byte* texels) {
  const auto join = [&](const auto& rule) { join_by_rule(rule, planes, shape, prediction.subtracts_green, texels); };
  const Predictor first = prediction.predictors[0];
  const bool is_one_for_all =
      std::all_of(prediction.predictors.begin(), prediction.predictors.begin() + static_cast<std::ptrdiff_t>(shape.channels),
                  [&](Predictor predictor) { return predictor == first; });
  if (is_one_for_all) return with_rule(first, join);
  join(PredictMixed(prediction.predictors));
}

}  // namespace vt::store
