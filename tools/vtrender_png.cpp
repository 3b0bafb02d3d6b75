#include "tools/vtrender_png.h"

#include <OpenImageIO/imageio.h>

#include <vector>

namespace vt::tools {

Result<void> write_picture(const std::filesystem::path& path, int width, int height, std::span<const std::uint8_t> rgba) {
  const auto row = static_cast<std::size_t>(width) * 3;
  std::vector<std::uint8_t> rgb(row * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* from = rgba.data() + static_cast<std::size_t>(height - 1 - y) * static_cast<std::size_t>(width) * 4;
    std::uint8_t* to = rgb.data() + static_cast<std::size_t>(y) * row;
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) *to++ = from[x * 4 + c];
  }
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(path.string());
  if (!out) return fail(ErrorCode::kUsage, path.string() + ": unknown picture format; use .png");
  const OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
  if (!out->open(path.string(), spec) || !out->write_image(OIIO::TypeDesc::UINT8, rgb.data()) || !out->close())
    return fail(ErrorCode::kIo, path.string() + ": cannot write the picture: " + out->geterror());
  return {};
}

}  // namespace vt::tools
