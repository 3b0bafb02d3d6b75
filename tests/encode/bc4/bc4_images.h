// Scalar pictures, their errors, and the peers that the tests and the benchmarks of BC4 and BC5 share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "builder/encode/quality.h"

namespace vt::encode {

// Interleaved 16-bit samples, tightly packed; width and height are multiples of 4.
struct Image16 {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 1;
  std::vector<std::uint16_t> samples;

  Image16(std::size_t w, std::size_t h, std::size_t c = 1) : width(w), height(h), channels(c), samples(w * h * c) {}
  [[nodiscard]] std::uint16_t& at(std::size_t x, std::size_t y, std::size_t c = 0) { return samples[(y * width + x) * channels + c]; }
  [[nodiscard]] std::uint16_t at(std::size_t x, std::size_t y, std::size_t c = 0) const { return samples[(y * width + x) * channels + c]; }
};

using Block16 = std::array<std::uint16_t, 16>;
[[nodiscard]] Block16 block_of(const Image16& image, std::size_t block, std::size_t channel = 0);

struct NamedImage16 {
  std::string name;
  Image16 image;
};
// One channel each: noise, narrow noise, ramps, smooth terrain, two values, middles with 0 and 255 beside
// them, flat blocks.
[[nodiscard]] std::vector<NamedImage16> scalar_images(std::size_t edge);
// x and y of the normals of steep terrain, (n + 1) / 2: slopes as a 10 m elevation model of high mountains
// has them.
[[nodiscard]] Image16 normals_image(std::size_t edge, unsigned seed);

[[nodiscard]] std::vector<std::byte> encoded(const Image16& image, Quality quality);
// stb_dxt's BC4 or BC5 of the samples rounded to 8 bits: an independent encoder that is widely used.
[[nodiscard]] std::vector<std::byte> encoded_by_stb(const Image16& image);
// libsquish's, likewise.
[[nodiscard]] std::vector<std::byte> encoded_by_squish(const Image16& image);

// Sum of squared differences in codes (0..255) of a block of one channel, in double.
[[nodiscard]] double squared_error(const Block16& texels, std::span<const std::byte, 8> block);
[[nodiscard]] double mean_squared_error(const Image16& image, const std::vector<std::byte>& blocks);

struct AngularError {
  double mean_deg, p99_deg, max_deg;
};
// Between the normals of the samples and those of the decoded blocks, z from x and y.
[[nodiscard]] AngularError angular_error(const Image16& normals, const std::vector<std::byte>& blocks);

}  // namespace vt::encode
