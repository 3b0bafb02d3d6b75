#include "tests/encode/bc1/squish_encoder.h"

#include <squish.h>

namespace vt::encode {

std::vector<std::byte> encoded_by_squish(const Image& image, bool iterative) {
  std::vector<squish::u8> rgba(image.width * image.height * 4, 255);
  for (std::size_t i = 0; i < image.width * image.height; ++i)
    for (std::size_t c = 0; c < 3; ++c) rgba[i * 4 + c] = std::to_integer<squish::u8>(image.rgb[i * 3 + c]);
  std::vector<std::byte> blocks(image.width * image.height / 2);
  squish::CompressImage(rgba.data(), static_cast<int>(image.width), static_cast<int>(image.height), blocks.data(),
                        squish::kDxt1 | (iterative ? squish::kColourIterativeClusterFit : squish::kColourClusterFit));
  return blocks;
}

}  // namespace vt::encode
