// Where the programs' pictures go: PNG and EXR through OpenImageIO, GeoTIFF through builder/source, all row
// by row. One thread. Files are written beside the target and renamed when they are whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "store/result.h"

namespace vt::cli {

enum class PictureKind { kPng, kExr, kTiff };
// By suffix. kUsage: the message lists the suffixes.
[[nodiscard]] Result<PictureKind> picture_kind(const std::filesystem::path& path);

struct PictureSpec {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int channels = 0;
  bool is_float = false;       // 32-bit floats; otherwise bytes. PNG takes only bytes, EXR only floats.
  bool last_is_alpha = false;  // straight
  bool is_srgb = false;        // bytes are sRGB codes, for formats that can say so
  // GeoTIFF only.
  std::optional<double> nodata;
  std::optional<geo::GeoTransform> transform;
  std::optional<geo::Crs> crs;
};

class PictureWriter {
 public:
  virtual ~PictureWriter() = default;
  // The next rows, channels interleaved, tightly packed.
  [[nodiscard]] virtual Result<void> write_rows(std::span<const std::byte> texels, std::int64_t rows) = 0;
  [[nodiscard]] virtual Result<void> finish() = 0;
};

[[nodiscard]] Result<std::unique_ptr<PictureWriter>> create_picture(const std::filesystem::path& path, const PictureSpec& spec);

}  // namespace vt::cli
