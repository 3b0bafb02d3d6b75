// Writes georeferenced TIFFs row by row: the inverse of the reader for what it covers. BigTIFF is chosen by
// itself when the data may pass 4 GB.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

struct GeoTiffSpec {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 1;
  SampleType sample_type = SampleType::kUint8;
  bool last_band_is_alpha = false;             // straight alpha
  std::optional<double> nodata;                // GDAL_NODATA
  std::optional<geo::GeoTransform> transform;  // outer-corner convention, written as PixelIsArea
  std::optional<geo::Crs> crs;
  enum class Compression { kNone, kDeflate, kLzw, kZstd, kJpeg } compression = Compression::kNone;
  int tile = 256;  // 0: strips of `rows_per_strip`
  std::int64_t rows_per_strip = 16;
};

class GeoTiffWriter {
 public:
  // Writes beside `path` and renames in finish().
  [[nodiscard]] static Result<GeoTiffWriter> create(const std::filesystem::path& path, const GeoTiffSpec& spec);
  GeoTiffWriter(GeoTiffWriter&&) noexcept;
  GeoTiffWriter& operator=(GeoTiffWriter&&) noexcept;
  ~GeoTiffWriter();  // without finish() the file is removed

  // The next `rows` rows, bands interleaved, tightly packed, native byte order.
  [[nodiscard]] Result<void> write_rows(std::span<const std::byte> samples, std::int64_t rows);
  [[nodiscard]] Result<void> finish();

 private:
  struct Impl;
  explicit GeoTiffWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace vt::source
