// Reads back what vtinspect wrote, with stb_image, OpenEXR and libtiff: none of our own code, nor
// OpenImageIO, which wrote the pictures. Throws when a file cannot be read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vt::test {

template <class Sample>
struct Picture {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<Sample> samples;  // interleaved
  [[nodiscard]] Sample at(int x, int y, int channel) const {
    return samples[static_cast<std::size_t>((y * width + x) * channels + channel)];
  }
};
[[nodiscard]] Picture<std::uint8_t> read_png(const std::filesystem::path& path);
// One channel "Y" of 32-bit floats.
[[nodiscard]] Picture<float> read_exr(const std::filesystem::path& path);

struct TiffFile {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 0;
  int bits_per_sample = 0;
  int extra_samples = 0;
  std::vector<double> pixel_scale;      // ModelPixelScaleTag
  std::vector<double> tie_point;        // ModelTiepointTag
  std::vector<std::uint16_t> geo_keys;  // GeoKeyDirectoryTag
  std::string nodata;                   // GDAL_NODATA
  std::vector<std::byte> samples;       // interleaved rows
  // A key whose value stands in the directory itself; -1 when it is not there.
  [[nodiscard]] int geo_key(int key) const;
};
[[nodiscard]] TiffFile read_tiff(const std::filesystem::path& path);

}  // namespace vt::test
