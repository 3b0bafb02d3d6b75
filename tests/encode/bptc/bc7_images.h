// Pictures with alpha, and errors, that the BC7 tests and the BPTC benchmark share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/encode/quality.h"
#include "tests/encode/bc1/bc1_images.h"

namespace vt::encode {

// RGBA, 8 bits each, tightly packed; width and height are multiples of 4.
struct RgbaImage {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::byte> rgba;

  RgbaImage(std::size_t w, std::size_t h) : width(w), height(h), rgba(w * h * 4) {}
  explicit RgbaImage(const Image& image);  // opaque
  void set(std::size_t x, std::size_t y, const std::array<int, 4>& color) {
    for (std::size_t c = 0; c < 4; ++c) rgba[(y * width + x) * 4 + c] = static_cast<std::byte>(color[c]);
  }
  [[nodiscard]] int get(std::size_t x, std::size_t y, std::size_t c) const { return std::to_integer<int>(rgba[(y * width + x) * 4 + c]); }
};

// The photograph of bc1_images.h with an alpha of its own: smooth in some parts, cut out with hard edges in
// others.
[[nodiscard]] RgbaImage photographic_alpha_image(std::size_t width, std::size_t height, unsigned seed);
[[nodiscard]] RgbaImage noise_rgba_image(std::size_t width, std::size_t height, unsigned seed);

[[nodiscard]] std::vector<std::byte> encoded_bc7(const RgbaImage& image, Quality quality);

// Sum of squared differences in all four channels, of every block.
[[nodiscard]] std::vector<int> bc7_block_errors(const RgbaImage& image, const std::vector<std::byte>& blocks);
// Mean over `channels` values a texel: 3 for opaque pictures, whose alpha adds nothing.
[[nodiscard]] double bc7_psnr_db(const RgbaImage& image, const std::vector<std::byte>& blocks, int channels);

}  // namespace vt::encode
