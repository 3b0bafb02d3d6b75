// The registry of formats: every format that is read, and the best known ones that are not, so that a message
// can name what it found. A file's content tells its format; the suffix decides nothing where the content
// does. No decoder is started to find out. Constant data, any thread. README.md says how a format is added.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "builder/source/files/file_bytes.h"
#include "builder/source/files/file_evidence.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

// A number or a word that a format puts at a fixed place.
struct Magic {
  std::size_t at = 0;
  std::string_view bytes;  // "": none
};

// How a file of a format that is not read gets read after all.
enum class Advice : std::uint8_t {
  kNone,       // it is read
  kTranslate,  // GDAL makes a GeoTIFF of it
  kVariable,   // likewise, of one of the rasters inside
  kPicture,    // a picture without a place: any converter will do
  kUnpack,     // an archive
  kNoRaster,
};

struct RasterFormat {
  std::string_view name;                      // for people, as "DTED"
  std::array<Magic, 4> magic = {};            // any of them tells the format,
  bool (*is_this)(const FileEvidence&) = {};  // or this does, where no fixed place tells it
  // In lower case: which files of a folder are rasters. A format without one is no tile of a mosaic, as
  // catalogues of rasters are not.
  std::array<std::string_view, 4> suffixes = {};
  bool shares_suffix = false;  // other files are called so, too: the content has to tell
  // Opens a file whose content is of this format; nullptr where it is known by name only.
  Result<std::unique_ptr<RasterSource>> (*open)(std::shared_ptr<const FileBytes> file, const OpenOptions& options) = nullptr;
  Advice advice = Advice::kNone;

  [[nodiscard]] bool has_suffix(const std::filesystem::path& path) const;
  [[nodiscard]] bool is_raster() const { return advice != Advice::kUnpack && advice != Advice::kNoRaster; }
};

// In the order in which they are tried.
[[nodiscard]] std::span<const RasterFormat> raster_formats();

// Those that are read, for people: "GeoTIFF, PNG and JPEG".
[[nodiscard]] std::string names_of_read_formats();

// nullptr: of no format that is known. kIo.
[[nodiscard]] Result<const RasterFormat*> format_of(const FileBytes& file);

// A format that is read. kUnsupported: another one; the message names it, when it is known, and the way to a
// format that is read. kInvalidData: an empty file.
[[nodiscard]] Result<const RasterFormat*> identify(const FileBytes& file);

}  // namespace vt::source
