#include "tests/encode/bc4/bc4_images.h"

#include <squish.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "builder/encode/bc4/bc4_encoder.h"
#include "store/texel/bc4.h"

#define STB_DXT_STATIC
#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace vt::encode {
namespace {

// A height field of octaves of random waves: smooth, with the slopes of each octave about equal.
double height(double x, double y, unsigned seed) {
  std::mt19937 random(seed);
  double sum = 0;
  for (double wavelength = 128; wavelength >= 4; wavelength *= 0.7) {
    const double direction = static_cast<double>(random()) * 1e-9, phase = static_cast<double>(random()) * 1e-8;
    const double bend = static_cast<double>(random()) * 1e-9;
    const double u = x * std::cos(direction) + y * std::sin(direction), v = y * std::cos(direction) - x * std::sin(direction);
    sum += 0.07 * wavelength * std::sin(6.2831853 * u / wavelength + phase + 2.0 * std::sin(v / wavelength * 3.0 + bend));
  }
  return sum;
}

std::uint16_t sample_of(double code) { return static_cast<std::uint16_t>(std::lround(std::clamp(code, 0.0, 255.0) * 257.0)); }

template <class Paint>
NamedImage16 painted(const std::string& name, std::size_t edge, const Paint& paint) {
  NamedImage16 named{name, Image16(edge, edge)};
  std::mt19937 random(7);
  for (std::size_t y = 0; y < edge; y += 4)
    for (std::size_t x = 0; x < edge; x += 4) paint(named.image, x, y, random);
  return named;
}

double uniform(std::mt19937& random, double low, double high) { return low + (high - low) * static_cast<double>(random()) / 4294967296.0; }

std::vector<std::byte> encoded_by(const Image16& image, void (*encode)(unsigned char* out, const Image16& image, std::size_t block)) {
  std::vector<std::byte> blocks(image.width * image.height / 2 * image.channels);
  for (std::size_t i = 0; i < blocks.size() / (8 * image.channels); ++i)
    encode(reinterpret_cast<unsigned char*>(blocks.data()) + i * 8 * image.channels, image, i);
  return blocks;
}

unsigned char rounded(std::uint16_t sample) { return static_cast<unsigned char>((sample + 128) / 257); }

}  // namespace

Block16 block_of(const Image16& image, std::size_t block, std::size_t channel) {
  const std::size_t x = block % (image.width / 4) * 4;
  const std::size_t y = block / (image.width / 4) * 4;
  Block16 texels{};
  for (std::size_t i = 0; i < 16; ++i) texels[i] = image.at(x + i % 4, y + i / 4, channel);
  return texels;
}

std::vector<NamedImage16> scalar_images(std::size_t edge) {
  std::vector<NamedImage16> images;
  const auto add = [&](const std::string& name, const auto& paint) { images.push_back(painted(name, edge, paint)); };
  add("noise", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    for (std::size_t i = 0; i < 16; ++i) image.at(x + i % 4, y + i / 4) = static_cast<std::uint16_t>(random());
  });
  add("narrow noise", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const double middle = uniform(random, 0, 255), width = uniform(random, 0.1, 12);
    for (std::size_t i = 0; i < 16; ++i) image.at(x + i % 4, y + i / 4) = sample_of(uniform(random, middle - width, middle + width));
  });
  add("ramps", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const double base = uniform(random, 0, 255), right = uniform(random, -12, 12), down = uniform(random, -12, 12);
    for (std::size_t i = 0; i < 16; ++i)
      image.at(x + i % 4, y + i / 4) = sample_of(base + right * static_cast<double>(i % 4) + down * static_cast<double>(i / 4));
  });
  add("terrain", [](Image16& image, std::size_t x, std::size_t y, std::mt19937&) {
    for (std::size_t i = 0; i < 16; ++i)
      image.at(x + i % 4, y + i / 4) = sample_of(128 + 4 * height(static_cast<double>(x + i % 4), static_cast<double>(y + i / 4), 3));
  });
  add("two values", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const double first = uniform(random, 0, 255), second = uniform(random, 0, 255);
    for (std::size_t i = 0; i < 16; ++i) image.at(x + i % 4, y + i / 4) = sample_of(random() % 2 == 0 ? first : second);
  });
  add("extremes and a middle", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const double middle = uniform(random, 0, 255), width = uniform(random, 0, 30), soft = random() % 2 == 0 ? 0 : uniform(random, 0, 4);
    const auto extremes = random() % 3;
    for (std::size_t i = 0; i < 16; ++i) {
      const double extreme =
          extremes == 0 || (extremes == 2 && random() % 2 == 0) ? uniform(random, 0, soft) : uniform(random, 255 - soft, 255);
      image.at(x + i % 4, y + i / 4) = sample_of(random() % 3 == 0 ? extreme : uniform(random, middle - width, middle + width));
    }
  });
  add("one hot texel", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const double base = uniform(random, 0, 255), hot = uniform(random, 0, 255), width = random() % 2 == 0 ? 0 : uniform(random, 0, 6);
    const std::size_t which = random() % 16;
    for (std::size_t i = 0; i < 16; ++i)
      image.at(x + i % 4, y + i / 4) = sample_of(i == which ? hot : uniform(random, base - width, base + width));
  });
  add("flat", [](Image16& image, std::size_t x, std::size_t y, std::mt19937& random) {
    const auto value = static_cast<std::uint16_t>(random());
    for (std::size_t i = 0; i < 16; ++i) image.at(x + i % 4, y + i / 4) = value;
  });
  return images;
}

Image16 normals_image(std::size_t edge, unsigned seed) {
  Image16 image(edge, edge, 2);
  for (std::size_t y = 0; y < edge; ++y) {
    for (std::size_t x = 0; x < edge; ++x) {
      const auto fx = static_cast<double>(x), fy = static_cast<double>(y);
      const double dx = (height(fx + 1, fy, seed) - height(fx - 1, fy, seed)) / 2;
      const double dy = (height(fx, fy + 1, seed) - height(fx, fy - 1, seed)) / 2;
      const double length = std::sqrt(1 + dx * dx + dy * dy);
      image.at(x, y, 0) = sample_of((1 - dx / length) * 127.5);
      image.at(x, y, 1) = sample_of((1 - dy / length) * 127.5);
    }
  }
  return image;
}

std::vector<std::byte> encoded(const Image16& image, Quality quality) {
  std::vector<std::byte> blocks(image.width * image.height / 2 * image.channels);
  const auto samples = std::as_bytes(std::span(image.samples));
  const std::size_t pitch = image.width * image.channels * 2;
  if (image.channels == 1) {
    encode_bc4_image(samples, image.width, image.height, pitch, quality, blocks);
  } else {
    encode_bc5_image(samples, image.width, image.height, pitch, quality, blocks);
  }
  return blocks;
}

std::vector<std::byte> encoded_by_stb(const Image16& image) {
  return encoded_by(image, [](unsigned char* out, const Image16& from, std::size_t block) {
    std::array<unsigned char, 32> texels{};
    for (std::size_t c = 0; c < from.channels; ++c)
      for (std::size_t i = 0; i < 16; ++i) texels[i * from.channels + c] = rounded(block_of(from, block, c)[i]);
    from.channels == 1 ? stb_compress_bc4_block(out, texels.data()) : stb_compress_bc5_block(out, texels.data());
  });
}

std::vector<std::byte> encoded_by_squish(const Image16& image) {
  return encoded_by(image, [](unsigned char* out, const Image16& from, std::size_t block) {
    std::array<unsigned char, 64> rgba{};
    for (std::size_t c = 0; c < from.channels; ++c)
      for (std::size_t i = 0; i < 16; ++i) rgba[i * 4 + c] = rounded(block_of(from, block, c)[i]);
    squish::Compress(rgba.data(), out, from.channels == 1 ? squish::kBc4 : squish::kBc5);
  });
}

double squared_error(const Block16& texels, std::span<const std::byte, 8> block) {
  const std::array<float, 16> values = store::decode_bc4_block(block);
  double sum = 0;
  for (std::size_t i = 0; i < 16; ++i) sum += std::pow(texels[i] / 257.0 - static_cast<double>(values[i]), 2);
  return sum;
}

double mean_squared_error(const Image16& image, const std::vector<std::byte>& blocks) {
  double sum = 0;
  for (std::size_t i = 0; i < blocks.size() / 8; ++i)
    sum += squared_error(block_of(image, i / image.channels, i % image.channels), std::span(blocks).subspan(i * 8).first<8>());
  return sum / static_cast<double>(image.samples.size());
}

AngularError angular_error(const Image16& normals, const std::vector<std::byte>& blocks) {
  std::vector<float> decoded(normals.samples.size());
  store::decode_bc5_image(blocks, normals.width, normals.height, decoded);
  const auto normal = [](double x, double y) -> std::array<double, 3> {
    const double nx = x / 127.5 - 1, ny = y / 127.5 - 1;
    const double nz = std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny));
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    return {nx / length, ny / length, nz / length};
  };
  std::vector<double> angles;
  double sum = 0;
  for (std::size_t i = 0; i < decoded.size(); i += 2) {
    const auto p = normal(normals.samples[i] / 257.0, normals.samples[i + 1] / 257.0);
    const auto q = normal(decoded[i], decoded[i + 1]);
    const std::array<double, 3> cross{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    const double sine = std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    angles.push_back(std::atan2(sine, p[0] * q[0] + p[1] * q[1] + p[2] * q[2]) * 57.29577951308232);
    sum += angles.back();
  }
  std::sort(angles.begin(), angles.end());
  return {sum / static_cast<double>(angles.size()), angles[angles.size() * 99 / 100], angles.back()};
}

}  // namespace vt::encode
