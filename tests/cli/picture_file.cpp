#include "tests/cli/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace vt::test {

Picture<std::uint8_t> read_png(const std::filesystem::path& path) {
  Picture<std::uint8_t> picture;
  const std::unique_ptr<stbi_uc, void (*)(void*)> samples(stbi_load(path.c_str(), &picture.width, &picture.height, &picture.channels, 0),
                                                          stbi_image_free);
  if (!samples) throw std::runtime_error(path.string() + ": " + stbi_failure_reason());
  const auto count =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * static_cast<std::size_t>(picture.channels);
  picture.samples.assign(samples.get(), samples.get() + count);
  return picture;
}

Picture<float> read_exr(const std::filesystem::path& path) {
  Imf::InputFile file(path.c_str());
  const Imf::Channel* const channel = file.header().channels().findChannel("Y");
  if (channel == nullptr || channel->type != Imf::FLOAT) throw std::runtime_error(path.string() + ": no 32-bit channel Y");
  const auto window = file.header().dataWindow();
  Picture<float> picture{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, 1, {}};
  if (window.min.x != 0 || window.min.y != 0) throw std::runtime_error(path.string() + ": does not start at 0,0");
  picture.samples.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
  Imf::FrameBuffer buffer;
  buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(picture.samples.data()), sizeof(float),
                                sizeof(float) * static_cast<std::size_t>(picture.width)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, picture.height - 1);
  return picture;
}

int TiffFile::geo_key(int key) const {
  // A header of four numbers, then four for each key: number, place of the value (0: here), count, value.
  for (std::size_t at = 4; at + 3 < geo_keys.size(); at += 4) {
    if (geo_keys[at] == key && geo_keys[at + 1] == 0) return geo_keys[at + 3];
  }
  return -1;
}

TiffFile read_tiff(const std::filesystem::path& path) {
  TIFFSetWarningHandler(nullptr);  // libtiff does not know the geographic tags and says so
  const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(TIFFOpen(path.c_str(), "r"), TIFFClose);
  if (!tiff) throw std::runtime_error(path.string() + ": cannot open");
  TIFF* const file = tiff.get();

  TiffFile result;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bands = 1;
  std::uint16_t bits = 0;
  std::uint16_t extra = 0;
  const std::uint16_t* extra_kinds = nullptr;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &bands);
  TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(file, TIFFTAG_EXTRASAMPLES, &extra, &extra_kinds);
  result.width = width;
  result.height = height;
  result.bands = bands;
  result.bits_per_sample = bits;
  result.extra_samples = extra;

  // Unknown tags come as a count, whose width depends on the tag's, and a pointer to the values.
  const auto numbers_of = [&](std::uint32_t tag, auto& values) {
    std::uint32_t count = 0;
    const void* data = nullptr;
    if (TIFFGetField(file, tag, &count, &data) != 1) return;
    values.resize(count);
    std::memcpy(values.data(), data, count * sizeof values[0]);
  };
  numbers_of(33550, result.pixel_scale);
  numbers_of(33922, result.tie_point);
  numbers_of(34735, result.geo_keys);
  numbers_of(42113, result.nodata);
  result.nodata = result.nodata.c_str();  // without the zero at its end

  const std::size_t texel_bytes = std::size_t{bands} * bits / 8;
  result.samples.resize(width * texel_bytes * height);
  if (TIFFIsTiled(file) != 0) {
    std::uint32_t tile_width = 0;
    std::uint32_t tile_height = 0;
    TIFFGetField(file, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(file, TIFFTAG_TILELENGTH, &tile_height);
    std::vector<std::byte> tile(static_cast<std::size_t>(TIFFTileSize(file)));
    for (std::uint32_t y = 0; y < height; y += tile_height) {
      for (std::uint32_t x = 0; x < width; x += tile_width) {
        if (TIFFReadTile(file, tile.data(), x, y, 0, 0) < 0) throw std::runtime_error(path.string() + ": cannot read a tile");
        const std::size_t part_bytes = std::min(tile_width, width - x) * texel_bytes;
        for (std::uint32_t row = 0; row < std::min(tile_height, height - y); ++row) {
          std::memcpy(&result.samples[(std::size_t{y + row} * width + x) * texel_bytes], &tile[std::size_t{row} * tile_width * texel_bytes],
                      part_bytes);
        }
      }
    }
  } else {
    for (std::uint32_t y = 0; y < height; ++y) {
      if (TIFFReadScanline(file, &result.samples[std::size_t{y} * width * texel_bytes], y, 0) < 0) {
        throw std::runtime_error(path.string() + ": cannot read a row");
      }
    }
  }
  return result;
}

}  // namespace vt::test
