// Pictures, errors and the peer that the BC1 tests and the BC1 benchmark share.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vt::encode {

// RGB, 8 bits each, tightly packed; width and height are multiples of 4.
struct Image {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::byte> rgb;

  Image() = default;
  Image(std::size_t w, std::size_t h) : width(w), height(h), rgb(w * h * 3) {}
  void set(std::size_t x, std::size_t y, const std::array<int, 3>& color) {
    for (std::size_t c = 0; c < 3; ++c) rgb[(y * width + x) * 3 + c] = static_cast<std::byte>(std::clamp(color[c], 0, 255));
  }
  [[nodiscard]] int get(std::size_t x, std::size_t y, std::size_t c) const { return std::to_integer<int>(rgb[(y * width + x) * 3 + c]); }
};

// Like a photograph from above: 1/f noise that the channels mostly share, smooth parts, and hard edges
// between areas of different colour.
[[nodiscard]] Image photographic_image(std::size_t width, std::size_t height, unsigned seed);
[[nodiscard]] Image noise_image(std::size_t width, std::size_t height, unsigned seed);
// A real raster of VT_TEST_DATA, bands 1 to 3, cut to multiples of 4. Empty when it is not there.
[[nodiscard]] std::optional<Image> real_image(const std::string& name);
extern const std::array<const char*, 6> kRealImages;

[[nodiscard]] std::vector<std::byte> encoded(const Image& image);
// stb_dxt in its high-quality mode: an independent encoder that is widely used.
[[nodiscard]] std::vector<std::byte> encoded_by_stb(const Image& image);

// Sum of squared differences of every block, and of the whole image in decibels.
[[nodiscard]] std::vector<int> block_errors(const Image& image, const std::vector<std::byte>& blocks);
[[nodiscard]] double mean_squared_error(const Image& image, const std::vector<std::byte>& blocks);
[[nodiscard]] double psnr_db(double mean_squared_error);

}  // namespace vt::encode
