#include "tests/encode/bc1/bc1_images.h"

#include <cmath>
#include <cstring>
#include <random>
#include <span>

#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/source/raster_source.h"
#include "store/texel/bc1.h"

#define STB_DXT_STATIC
#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace vt::encode {
namespace {

// Smooth random field: bilinear interpolation of random values on a lattice.
class Lattice {
 public:
  Lattice(std::size_t width, std::size_t height, std::size_t cell, std::mt19937& random)
      : cell_(static_cast<double>(cell)), stride_(width / cell + 2), values_(stride_ * (height / cell + 2)) {
    for (double& value : values_) value = static_cast<double>(random()) / 2147483648.0 - 1.0;
  }
  double at(std::size_t x, std::size_t y) const {
    const double fx = static_cast<double>(x) / cell_, fy = static_cast<double>(y) / cell_;
    const auto i = static_cast<std::size_t>(fx), j = static_cast<std::size_t>(fy);
    const double tx = fx - static_cast<double>(i), ty = fy - static_cast<double>(j);
    const double* v = &values_[j * stride_ + i];
    return (v[0] * (1 - tx) + v[1] * tx) * (1 - ty) + (v[stride_] * (1 - tx) + v[stride_ + 1] * tx) * ty;
  }

 private:
  double cell_;
  std::size_t stride_;
  std::vector<double> values_;
};

}  // namespace

const std::array<const char*, 6> kRealImages{"farm_cir_2m.tif",
                                             "hro_colorado_0x15m.tif",
                                             "rmnp-rgb.tif",
                                             "sba_rgb_wgs84_512x512.tif",
                                             "everest_LE71400412000304SGS00_RGB.tif",
                                             "swellendam_3320D_2010_315_RGB_LATLNG.tif"};

Image photographic_image(std::size_t width, std::size_t height, unsigned seed) {
  std::mt19937 random(seed);
  // Octaves of equal energy per octave are 1/f; brightness first, then a little of its own for each channel.
  std::vector<Lattice> brightness, tint;
  for (std::size_t cell = 1; cell <= 128; cell *= 2) brightness.emplace_back(width, height, cell, random);
  for (std::size_t channel = 0; channel < 3; ++channel)
    for (std::size_t cell = 8; cell <= 64; cell *= 4) tint.emplace_back(width, height, cell, random);
  const Lattice regions_a(width, height, 61, random), regions_b(width, height, 37, random), contrast(width, height, 96, random);
  constexpr std::array<std::array<double, 3>, 4> kColors{{{70, 92, 48}, {150, 130, 100}, {52, 80, 112}, {196, 190, 182}}};
  Image image(width, height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t region = (regions_a.at(x, y) > 0 ? 1U : 0U) + (regions_b.at(x, y) > 0.2 ? 2U : 0U);
      const double strength = 2.0 + 12.0 * std::max(0.0, contrast.at(x, y) + 0.3);
      double light = 0;
      for (const Lattice& octave : brightness) light += octave.at(x, y) * strength;
      std::array<int, 3> color{};
      for (std::size_t c = 0; c < 3; ++c) {
        double own = 0;
        for (std::size_t i = 0; i < 2; ++i) own += tint[c * 2 + i].at(x, y) * 7.0;
        color[c] = static_cast<int>(std::lround(kColors[region][c] + light * (0.85 + 0.15 * static_cast<double>(c)) + own));
      }
      image.set(x, y, color);
    }
  }
  return image;
}

Image noise_image(std::size_t width, std::size_t height, unsigned seed) {
  Image image(width, height);
  std::mt19937 random(seed);
  for (std::byte& value : image.rgb) value = static_cast<std::byte>(random());
  return image;
}

std::optional<Image> real_image(const std::string& name) {
  const auto source = source::open_raster(VT_TEST_DATA "/imagery/" + name);
  if (!source) return std::nullopt;
  const source::RasterInfo& info = (*source)->info();
  Image image(static_cast<std::size_t>(info.width) & ~std::size_t{3}, static_cast<std::size_t>(info.height) & ~std::size_t{3});
  const std::array<int, 3> bands{0, 1, 2};
  const source::Window window{
      .x = 0, .y = 0, .width = static_cast<std::int64_t>(image.width), .height = static_cast<std::int64_t>(image.height)};
  if (!(*source)->read(window, bands, image.rgb, image.width * 3)) return std::nullopt;
  return image;
}

std::vector<std::byte> encoded(const Image& image) {
  std::vector<std::byte> blocks(image.width * image.height / 2);
  encode_bc1_image(image.rgb, image.width, image.height, image.width * 3, 3, blocks);
  return blocks;
}

std::vector<std::byte> encoded_by_stb(const Image& image) {
  std::vector<std::byte> blocks(image.width * image.height / 2);
  auto* out = reinterpret_cast<unsigned char*>(blocks.data());
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4, out += 8) {
      std::array<unsigned char, 64> rgba{};
      for (std::size_t i = 0; i < 16; ++i) {
        std::memcpy(&rgba[i * 4], &image.rgb[((y + i / 4) * image.width + x + i % 4) * 3], 3);
        rgba[i * 4 + 3] = 255;
      }
      stb_compress_dxt_block(out, rgba.data(), 0, STB_DXT_HIGHQUAL);
    }
  }
  return blocks;
}

std::vector<int> block_errors(const Image& image, const std::vector<std::byte>& blocks) {
  std::vector<int> errors;
  errors.reserve(blocks.size() / 8);
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto texels = store::decode_bc1_block(std::span(blocks).subspan(errors.size() * 8).first<8>());
      int error = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          const int d = texels[i][c] - image.get(x + i % 4, y + i / 4, c);
          error += d * d;
        }
      }
      errors.push_back(error);
    }
  }
  return errors;
}

double mean_squared_error(const Image& image, const std::vector<std::byte>& blocks) {
  double sum = 0;
  for (const int error : block_errors(image, blocks)) sum += error;
  return sum / static_cast<double>(image.rgb.size());
}

double psnr_db(double mean_squared_error) { return 10.0 * std::log10(255.0 * 255.0 / mean_squared_error); }

}  // namespace vt::encode
