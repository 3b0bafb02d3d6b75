#include "tests/encode/bptc/bptc_peers.h"

#include <OpenImageIO/imageio.h>

#include <array>
#include <fstream>

namespace vt::encode {

std::optional<std::vector<float>> decoded_by_openimageio(BptcFormat format, std::span<const std::byte> blocks, std::size_t width,
                                                         std::size_t height, const std::string& folder, std::string& why) {
  // Microsoft's DDS: magic, DDS_HEADER (31 numbers), DDS_HEADER_DXT10 (5 numbers).
  constexpr std::uint32_t kDxgiBc6hUf16 = 95, kDxgiBc7Unorm = 98;
  std::array<std::uint32_t, 37> header{};
  header[0] = 0x20534444;  // "DDS "
  header[1] = 124;
  header[2] = 0x1 | 0x2 | 0x4 | 0x1000 | 0x80000;  // caps, height, width, pixel format, linear size
  header[3] = static_cast<std::uint32_t>(height);
  header[4] = static_cast<std::uint32_t>(width);
  header[5] = static_cast<std::uint32_t>(blocks.size());
  header[19] = 32;          // size of the pixel format
  header[20] = 0x4;         // it has a four-character code
  header[21] = 0x30315844;  // "DX10"
  header[27] = 0x1000;      // a texture
  header[32] = format == BptcFormat::kBc7 ? kDxgiBc7Unorm : kDxgiBc6hUf16;
  header[33] = 3;  // two dimensions
  header[35] = 1;  // array of one
  const std::string path = folder + (format == BptcFormat::kBc7 ? "/bc7.dds" : "/bc6h.dds");
  {
    std::ofstream file(path, std::ios::binary);
    for (const std::uint32_t value : header)
      for (unsigned shift = 0; shift < 32; shift += 8) file.put(static_cast<char>(value >> shift));
    file.write(reinterpret_cast<const char*>(blocks.data()), static_cast<std::streamsize>(blocks.size()));
    if (!file) {
      why = path + ": cannot write";
      return std::nullopt;
    }
  }
  const auto input = OIIO::ImageInput::open(path);
  if (!input) {
    why = OIIO::geterror();
    return std::nullopt;
  }
  const int channels = input->spec().nchannels;
  std::vector<float> read(width * height * static_cast<std::size_t>(channels));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, read.data())) {
    why = input->geterror();
    return std::nullopt;
  }
  std::vector<float> texels(width * height * 4, 1.0F);
  for (std::size_t i = 0; i < width * height; ++i)
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
      texels[i * 4 + c] = read[i * static_cast<std::size_t>(channels) + c];
  return texels;
}

}  // namespace vt::encode
