// Which format a file is in, known by its content; the suffix decides nothing where the content does. Every format that is read is here,
// and the best known ones that are not, so that a message can name what it found. No decoder is started to find out. Any thread.
#pragma once

#include <cstdint>
#include <string>

#include "builder/source/files/file_bytes.h"
#include "store/result.h"

namespace vt::source {

enum class RasterFormat : std::uint8_t { kTiff, kPng, kJpeg, kJpeg2000, kOpenExr, kRadiance, kPnm };

// "GeoTIFF, PNG, JPEG, JPEG 2000, OpenEXR, Radiance HDR and PNM".
inline constexpr const char* kReadFormats = "GeoTIFF, PNG, JPEG, JPEG 2000, OpenEXR, Radiance HDR and PNM (PBM, PGM, PPM)";

// kUnsupported: another format; the message names it, when it is known, and the way to a format that is read. kInvalidData: an empty file.
[[nodiscard]] Result<RasterFormat> identify(const FileBytes& file);

// The name of a raster format that is not read, as "SRTM height tile (HGT)"; "" for a format that is read, for what is no raster, and for
// files of no known format.
[[nodiscard]] Result<std::string> foreign_name(const FileBytes& file);

}  // namespace vt::source
