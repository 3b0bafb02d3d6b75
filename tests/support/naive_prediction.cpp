#include "tests/support/naive_prediction.h"

#include <algorithm>
#include <stdexcept>

namespace vt::test {
namespace {

using Bytes = std::span<const std::byte>;

// All values of one channel, wide enough that nothing overflows before the modulus is taken.
struct Channel {
  const NaivePrediction& prediction;
  std::vector<std::int64_t> values;

  explicit Channel(const NaivePrediction& p) : prediction(p), values(p.width * p.height) {}
  [[nodiscard]] std::int64_t modulus() const { return std::int64_t{1} << (8 * prediction.sample_bytes); }
  [[nodiscard]] std::int64_t reduced(std::int64_t value) const { return ((value % modulus()) + modulus()) % modulus(); }
  [[nodiscard]] std::int64_t at(std::size_t x, std::size_t y) const { return values[y * prediction.width + x]; }

  [[nodiscard]] std::int64_t predicted(unsigned predictor, std::size_t x, std::size_t y) const {
    std::int64_t a = x > 0 ? at(x - 1, y) : 0;
    std::int64_t b = y > 0 ? at(x, y - 1) : 0;
    std::int64_t c = x > 0 && y > 0 ? at(x - 1, y - 1) : 0;
    if (y == 0) b = c = a;
    if (x == 0) a = c = b;
    switch (predictor) {
      case 0:
        return 0;
      case 1:
        return a;
      case 2:
        return b;
      case 3:
        return (a + b + 1) / 2;
      case 4:
        return reduced(a + b - c);
      case 5:
        return reduced(a + b - std::clamp(c, std::min(a, b), std::max(a, b)));
      default:
        throw std::runtime_error("tile store: not so: a predictor is 0 to 5");
    }
  }
};

std::int64_t byte_at(Bytes bytes, std::size_t at) { return std::to_integer<std::int64_t>(bytes[at]); }

// The bits of a value of so many bytes.
std::int64_t top_bit(const NaivePrediction& p) { return std::int64_t{1} << (8 * p.sample_bytes - 1); }
std::int64_t all_bits(const NaivePrediction& p) { return 2 * top_bit(p) - 1; }

}  // namespace

std::vector<std::byte> naive_texels(Bytes planes, const NaivePrediction& p) {
  const std::size_t sample_bytes = p.sample_bytes;
  const std::size_t channels = p.predictors.size();
  const std::size_t area = p.width * p.height;
  if (planes.size() != area * channels * sample_bytes) throw std::runtime_error("tile store: not so: the planes fill the tile");

  std::vector<std::byte> texels(planes.size());
  std::vector<Channel> decoded;
  for (std::size_t c = 0; c < channels; ++c) {
    Channel channel(p);
    for (std::size_t i = 0; i < area; ++i) {
      std::int64_t residual = 0;
      for (std::size_t k = 0; k < sample_bytes; ++k) residual = residual * 256 + byte_at(planes, (c * sample_bytes + k) * area + i);
      if (sample_bytes > 1) residual = residual % 2 == 0 ? residual / 2 : -(residual + 1) / 2;
      channel.values[i] = channel.reduced(residual + channel.predicted(p.predictors[c], i % p.width, i / p.width));
    }
    decoded.push_back(channel);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t i = 0; i < area; ++i) {
      std::int64_t value = decoded[c].values[i];
      if (p.subtracts_green && (c == 0 || c == 2)) value = (value + decoded[1].values[i] + 128) % 256;
      if (p.is_float) value = value >= top_bit(p) ? value - top_bit(p) : all_bits(p) - value;
      for (std::size_t k = 0; k < sample_bytes; ++k)
        texels[(i * channels + c) * sample_bytes + k] = static_cast<std::byte>((value >> (8 * k)) & 255);
    }
  }
  return texels;
}

std::vector<std::byte> naive_planes(Bytes texels, const NaivePrediction& p) {
  const std::size_t sample_bytes = p.sample_bytes;
  const std::size_t channels = p.predictors.size();
  const std::size_t area = p.width * p.height;
  if (texels.size() != area * channels * sample_bytes) throw std::runtime_error("tile store: not so: the texels fill the tile");

  std::vector<std::byte> planes(texels.size());
  for (std::size_t c = 0; c < channels; ++c) {
    Channel channel(p);
    for (std::size_t i = 0; i < area; ++i) {
      std::int64_t value = 0;
      for (std::size_t k = sample_bytes; k-- > 0;) value = value * 256 + byte_at(texels, (i * channels + c) * sample_bytes + k);
      if (p.subtracts_green && (c == 0 || c == 2)) value = channel.reduced(value - byte_at(texels, i * channels + 1) + 128);
      if (p.is_float) value = value >= top_bit(p) ? all_bits(p) - value : value + top_bit(p);
      channel.values[i] = value;
    }
    for (std::size_t i = 0; i < area; ++i) {
      const std::int64_t r = channel.reduced(channel.values[i] - channel.predicted(p.predictors[c], i % p.width, i / p.width));
      const std::int64_t coded = sample_bytes == 1 ? r : r < top_bit(p) ? r * 2 : (all_bits(p) + 1 - r) * 2 - 1;
      for (std::size_t k = 0; k < sample_bytes; ++k)
        planes[(c * sample_bytes + k) * area + i] = static_cast<std::byte>((coded >> (8 * (sample_bytes - 1 - k))) & 255);
    }
  }
  return planes;
}

}  // namespace vt::test
