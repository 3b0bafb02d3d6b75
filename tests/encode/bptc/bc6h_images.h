// Pictures of light in half floats, and errors, that the BC6H tests and the BPTC benchmark share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/encode/quality.h"

namespace vt::encode {

// RGBA of halves, tightly packed; width and height are multiples of 4.
struct HalfImage {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint16_t> rgba;

  HalfImage(std::size_t w, std::size_t h) : width(w), height(h), rgba(w * h * 4) {}
  void set(std::size_t x, std::size_t y, const std::array<double, 3>& light);
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(rgba)); }
};

// The definition of binary16 in real numbers, for what is not negative; `half_of` is to nearest and at most
// 65504.
[[nodiscard]] double light_of(std::uint16_t half);
[[nodiscard]] std::uint16_t half_of(double light);

// The photograph of bc1_images.h by day: linear light over about eight octaves, smooth shading and hard
// edges.
[[nodiscard]] HalfImage day_image(std::size_t width, std::size_t height, unsigned seed);
// A town by night: lamps from 1 to 30000 that fall off with the square of the distance, over dark ground with
// a little noise.
[[nodiscard]] HalfImage night_image(std::size_t width, std::size_t height, unsigned seed);
// A city from above, as codes of a photograph made light: black, with dots of one to four texels in warm and
// cold colours and a faint glow.
[[nodiscard]] HalfImage city_lights(std::size_t width, std::size_t height, unsigned seed);
// The mean of every four texels; width and height are multiples of 8.
[[nodiscard]] HalfImage halved(const HalfImage& image);
// Independent channels, every texel anywhere within `octaves`.
[[nodiscard]] HalfImage noise_half_image(std::size_t width, std::size_t height, double octaves, unsigned seed);

[[nodiscard]] std::vector<std::byte> encoded_bc6h(const HalfImage& image, Quality quality);

// Root mean square of the differences of half codes, in octaves (1024 codes each), and the sum of squares of
// every block, in codes.
[[nodiscard]] double rms_octaves(const HalfImage& image, const std::vector<std::byte>& blocks);
[[nodiscard]] std::vector<double> bc6h_block_errors(const HalfImage& image, const std::vector<std::byte>& blocks);
// Sum of light, decoded / source, of each channel.
[[nodiscard]] std::array<double, 3> light_ratios(const HalfImage& image, const std::vector<std::byte>& blocks);

}  // namespace vt::encode
