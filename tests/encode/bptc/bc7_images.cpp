#include "tests/encode/bptc/bc7_images.h"

#include <cmath>
#include <random>

#include "builder/encode/bptc/bc7_encoder.h"
#include "store/texel/bc7.h"

namespace vt::encode {

RgbaImage::RgbaImage(const Image& image) : RgbaImage(image.width, image.height) {
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) set(x, y, {image.get(x, y, 0), image.get(x, y, 1), image.get(x, y, 2), 255});
}

RgbaImage photographic_alpha_image(std::size_t width, std::size_t height, unsigned seed) {
  RgbaImage image(photographic_image(width, height, seed));
  const Image mask = photographic_image(width, height, seed + 100);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const int brightness = mask.get(x, y, 1);
      const bool is_cut_out = x / 64 % 2 == 0;
      image.rgba[(y * width + x) * 4 + 3] = static_cast<std::byte>(is_cut_out ? (brightness > 110 ? 255 : 0) : brightness);
    }
  }
  return image;
}

RgbaImage noise_rgba_image(std::size_t width, std::size_t height, unsigned seed) {
  RgbaImage image(width, height);
  std::mt19937 random(seed);
  for (std::byte& value : image.rgba) value = static_cast<std::byte>(random());
  return image;
}

std::vector<std::byte> encoded_bc7(const RgbaImage& image, Quality quality) {
  std::vector<std::byte> blocks(image.width * image.height);
  encode_bc7_image(image.rgba, image.width, image.height, image.width * 4, quality, blocks);
  return blocks;
}

std::vector<int> bc7_block_errors(const RgbaImage& image, const std::vector<std::byte>& blocks) {
  std::vector<int> errors;
  errors.reserve(blocks.size() / 16);
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto texels = store::decode_bc7_block(std::span(blocks).subspan(errors.size() * 16).first<16>());
      int error = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t c = 0; c < 4; ++c) {
          const int d = texels[i][c] - image.get(x + i % 4, y + i / 4, c);
          error += d * d;
        }
      }
      errors.push_back(error);
    }
  }
  return errors;
}

double bc7_psnr_db(const RgbaImage& image, const std::vector<std::byte>& blocks, int channels) {
  double sum = 0;
  for (const int error : bc7_block_errors(image, blocks)) sum += error;
  return psnr_db(sum / static_cast<double>(image.width * image.height) / channels);
}

}  // namespace vt::encode
