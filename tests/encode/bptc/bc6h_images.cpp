#include "tests/encode/bptc/bc6h_images.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "builder/encode/bptc/bc6h_encoder.h"
#include "store/texel/bc6h.h"
#include "tests/encode/bc1/bc1_images.h"

namespace vt::encode {

double light_of(std::uint16_t half) {
  const int exponent = half >> 10;
  const int mantissa = half & 1023;
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
}

std::uint16_t half_of(double light) {
  if (light >= 65504) return 0x7BFF;
  const int exponent = std::max(1, light > 0 ? std::ilogb(light) + 15 : 1);
  // Mantissa with its leading one, or without it below 2^-14; a carry into the next octave is what it should
  // be.
  const auto mantissa = static_cast<int>(std::nearbyint(std::ldexp(light, 25 - exponent)));
  return static_cast<std::uint16_t>((exponent - 1) * 1024 + mantissa);
}

void HalfImage::set(std::size_t x, std::size_t y, const std::array<double, 3>& light) {
  for (std::size_t c = 0; c < 3; ++c) rgba[(y * width + x) * 4 + c] = half_of(light[c]);
  rgba[(y * width + x) * 4 + 3] = 0x3C00;
}

HalfImage day_image(std::size_t width, std::size_t height, unsigned seed) {
  const Image image = photographic_image(width, height, seed);
  HalfImage light(width, height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      std::array<double, 3> color{};
      for (std::size_t c = 0; c < 3; ++c) color[c] = std::exp2((image.get(x, y, c) - 128.0) / 32.0);
      light.set(x, y, color);
    }
  }
  return light;
}

HalfImage night_image(std::size_t width, std::size_t height, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * static_cast<double>(random()) / 4294967296.0; };
  struct Lamp {
    double x, y, power;
    std::array<double, 3> color;
  };
  std::vector<Lamp> lamps(width * height / 2048);
  for (Lamp& lamp : lamps) {
    lamp = {.x = uniform(0, static_cast<double>(width)),
            .y = uniform(0, static_cast<double>(height)),
            .power = std::exp2(uniform(0, 15)),
            .color = {1.0, uniform(0.4, 1.0), uniform(0.1, 1.0)}};
  }
  HalfImage image(width, height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      std::array<double, 3> light{};
      for (std::size_t c = 0; c < 3; ++c) light[c] = 0.002 * uniform(0.8, 1.2);
      for (const Lamp& lamp : lamps) {
        const double dx = static_cast<double>(x) - lamp.x, dy = static_cast<double>(y) - lamp.y;
        const double distance2 = dx * dx + dy * dy;
        if (distance2 > 4096) continue;
        for (std::size_t c = 0; c < 3; ++c) light[c] += lamp.power * lamp.color[c] / (1.0 + distance2) * 0.1;
      }
      image.set(x, y, light);
    }
  }
  return image;
}

HalfImage city_lights(std::size_t width, std::size_t height, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * static_cast<double>(random()) / 4294967296.0; };
  std::vector<std::array<double, 3>> codes(width * height);  // 0 to 1, sRGB
  for (std::array<double, 3>& code : codes) {
    const double glow = std::max(0.0, uniform(-0.02, 0.06));
    for (double& value : code) value = glow * uniform(0.8, 1.0);
  }
  for (std::size_t lamp = 0; lamp < width * height / 60; ++lamp) {
    const std::array<double, 3> color{1.0, uniform(0.5, 1.0), uniform(0.2, 1.0)};
    const double brightness = uniform(0.1, 1.0);
    const std::size_t x = random() % width, y = random() % height;
    for (std::size_t dy = 0; dy < 1 + random() % 2; ++dy)
      for (std::size_t dx = 0; dx < 1 + random() % 2; ++dx)
        for (std::size_t c = 0; c < 3; ++c) {
          double& value = codes[(y + dy) % height * width + (x + dx) % width][c];
          value = std::min(1.0, value + brightness * color[c]);
        }
  }
  HalfImage image(width, height);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    std::array<double, 3> light{};
    for (std::size_t c = 0; c < 3; ++c)
      light[c] = 50.0 * (codes[i][c] <= 0.04045 ? codes[i][c] / 12.92 : std::pow((codes[i][c] + 0.055) / 1.055, 2.4));
    image.set(i % width, i / width, light);
  }
  return image;
}

HalfImage halved(const HalfImage& image) {
  HalfImage half(image.width / 2, image.height / 2);
  for (std::size_t y = 0; y < half.height; ++y)
    for (std::size_t x = 0; x < half.width; ++x) {
      std::array<double, 3> light{};
      for (std::size_t c = 0; c < 3; ++c)
        for (const std::size_t at : {std::size_t{0}, std::size_t{1}, image.width, image.width + 1})
          light[c] += 0.25 * light_of(image.rgba[(2 * y * image.width + 2 * x + at) * 4 + c]);
      half.set(x, y, light);
    }
  return half;
}

HalfImage noise_half_image(std::size_t width, std::size_t height, double octaves, unsigned seed) {
  std::mt19937 random(seed);
  HalfImage image(width, height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      std::array<double, 3> light{};
      for (double& value : light) value = std::exp2(octaves * (static_cast<double>(random()) / 4294967296.0 - 0.5));
      image.set(x, y, light);
    }
  }
  return image;
}

std::vector<std::byte> encoded_bc6h(const HalfImage& image, Quality quality) {
  std::vector<std::byte> blocks(image.width * image.height);
  encode_bc6h_image(image.bytes(), image.width, image.height, image.width * 8, quality, blocks);
  return blocks;
}

std::vector<double> bc6h_block_errors(const HalfImage& image, const std::vector<std::byte>& blocks) {
  std::vector<double> errors;
  errors.reserve(blocks.size() / 16);
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto texels = store::decode_bc6h_block(std::span(blocks).subspan(errors.size() * 16).first<16>());
      double error = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          const double d = texels[i][c] - image.rgba[((y + i / 4) * image.width + x + i % 4) * 4 + c];
          error += d * d;
        }
      }
      errors.push_back(error);
    }
  }
  return errors;
}

double rms_octaves(const HalfImage& image, const std::vector<std::byte>& blocks) {
  double sum = 0;
  for (const double error : bc6h_block_errors(image, blocks)) sum += error;
  return std::sqrt(sum / static_cast<double>(image.width * image.height * 3)) / 1024.0;
}

std::array<double, 3> light_ratios(const HalfImage& image, const std::vector<std::byte>& blocks) {
  std::vector<std::byte> decoded(image.rgba.size() * 2);
  store::decode_bc6h_image(blocks, image.width, image.height, decoded);
  std::array<double, 3> source{}, result{};
  for (std::size_t i = 0; i < image.width * image.height; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = (i * 4 + c) * 2;
      source[c] += light_of(image.rgba[i * 4 + c]);
      result[c] +=
          light_of(static_cast<std::uint16_t>(std::to_integer<unsigned>(decoded[at]) | std::to_integer<unsigned>(decoded[at + 1]) << 8U));
    }
  }
  return {result[0] / source[0], result[1] / source[1], result[2] / source[2]};
}

}  // namespace vt::encode
