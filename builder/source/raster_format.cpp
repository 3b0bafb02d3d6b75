#include "builder/source/raster_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>

namespace vt::source {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t kHeadBytes = 1024;

enum class Advice : std::uint8_t {
  kTranslate,  // GDAL makes a GeoTIFF of it
  kVariable,   // likewise, of one of the rasters inside
  kPicture,    // a picture without a place: any converter will do
  kUnpack,     // an archive
  kNoRaster,
};

struct Foreign {
  std::string_view name;
  Advice advice;
};

struct MagicRow {
  std::size_t at;
  std::string_view bytes;
  Foreign format;
};

// Numbers and words that formats put at a fixed place, in the order in which they are tried.
constexpr MagicRow kForeignMagic[] = {
    {0, "NITF0"sv, {"NITF", Advice::kTranslate}},
    {0, "NSIF0"sv, {"NSIF", Advice::kTranslate}},
    {0, "EHFA_HEADER_TAG"sv, {"ERDAS Imagine raster (IMG)", Advice::kTranslate}},
    {68, "GPKG"sv, {"GeoPackage", Advice::kTranslate}},
    {68, "GP10"sv, {"GeoPackage", Advice::kTranslate}},
    {68, "GP11"sv, {"GeoPackage", Advice::kTranslate}},
    {68, "MPBX"sv, {"MBTiles tile set", Advice::kTranslate}},
    {0, "SQLite format 3\0"sv, {"SQLite database (MBTiles, GeoPackage)", Advice::kTranslate}},
    {0, "PMTiles"sv, {"PMTiles tile set", Advice::kTranslate}},
    {0, "msid"sv, {"MrSID raster", Advice::kTranslate}},
    {0, "CDF\x01"sv, {"netCDF", Advice::kVariable}},
    {0, "CDF\x02"sv, {"netCDF", Advice::kVariable}},
    {0, "CDF\x05"sv, {"netCDF", Advice::kVariable}},
    {0, "\x89HDF\r\n\x1a\n"sv, {"HDF5 or netCDF-4", Advice::kVariable}},
    {0, "\x0e\x03\x13\x01"sv, {"HDF4", Advice::kVariable}},
    {0, "GRIB"sv, {"GRIB", Advice::kTranslate}},
    {0, "UHL1"sv, {"DTED", Advice::kTranslate}},
    {80, "UHL1"sv, {"DTED", Advice::kTranslate}},
    {160, "UHL1"sv, {"DTED", Advice::kTranslate}},
    {0, "DSAA"sv, {"Surfer grid", Advice::kTranslate}},
    {0, "DSBB"sv, {"Surfer grid", Advice::kTranslate}},
    {0, "DSRB"sv, {"Surfer grid", Advice::kTranslate}},
    {0, "PCIDSK  "sv, {"PCIDSK raster", Advice::kTranslate}},
    {0, "TERRAGENTERRAIN "sv, {"Terragen terrain", Advice::kTranslate}},
    {0, "binterr"sv, {"VTP binary terrain (BT)", Advice::kTranslate}},
    {0, "Lerc2 "sv, {"LERC blob", Advice::kTranslate}},
    {0, "CntZImage "sv, {"LERC blob", Advice::kTranslate}},
    {0, "SIMPLE  ="sv, {"FITS", Advice::kTranslate}},
    {0, "\x01\xda"sv, {"SGI picture", Advice::kPicture}},
    {0, "BM"sv, {"BMP picture", Advice::kPicture}},
    {0, "GIF8"sv, {"GIF picture", Advice::kPicture}},
    {8, "WEBP"sv, {"WebP picture", Advice::kPicture}},
    {0, "8BPS"sv, {"Photoshop picture (PSD)", Advice::kPicture}},
    {0, "DDS "sv, {"DDS texture", Advice::kPicture}},
    {0, "\xabKTX "sv, {"KTX texture", Advice::kPicture}},
    {0, "SDPX"sv, {"DPX picture", Advice::kPicture}},
    {0, "XPDS"sv, {"DPX picture", Advice::kPicture}},
    {0, "\xff\x0a"sv, {"JPEG XL picture", Advice::kPicture}},
    {4, "JXL \r\n"sv, {"JPEG XL picture", Advice::kPicture}},
    {4, "ftyp"sv, {"HEIF or AVIF picture", Advice::kPicture}},
    {0, "P7\n"sv, {"PAM picture", Advice::kPicture}},
    {0, "\0\0\x01\0"sv, {"Windows icon (ICO)", Advice::kPicture}},
    {0, "\0\0\x02\0"sv, {"Windows cursor or TGA picture", Advice::kPicture}},
    {0, "%PDF"sv, {"PDF document", Advice::kTranslate}},
    {0, "PK\x03\x04"sv, {"ZIP archive", Advice::kUnpack}},
    {0, "\x1f\x8b"sv, {"gzip archive", Advice::kUnpack}},
    {0, "BZh"sv, {"bzip2 archive", Advice::kUnpack}},
    {0,
     "\xfd"
     "7zXZ"sv,
     {"xz archive", Advice::kUnpack}},
    {0, "7z\xbc\xaf"sv, {"7-Zip archive", Advice::kUnpack}},
    {257, "ustar"sv, {"tar archive", Advice::kUnpack}},
    {0, "LASF"sv, {"LAS point cloud", Advice::kNoRaster}},
    {0, "\0\0\x27\x0a"sv, {"shapefile", Advice::kNoRaster}},
    {0, "VTSTORE1"sv, {"tile store, which this program writes", Advice::kNoRaster}},
};

struct ReadRow {
  std::string_view bytes;
  RasterFormat format;
};
constexpr ReadRow kReadMagic[] = {
    {"II*\0"sv, RasterFormat::kTiff},
    {"MM\0*"sv, RasterFormat::kTiff},
    {"II+\0"sv, RasterFormat::kTiff},  // BigTIFF
    {"MM\0+"sv, RasterFormat::kTiff},
    {"\x89PNG\r\n\x1a\n"sv, RasterFormat::kPng},
    {"\xff\xd8\xff"sv, RasterFormat::kJpeg},
    {"\0\0\0\x0cjP  \r\n\x87\n"sv, RasterFormat::kJpeg2000},
    {"\xff\x4f\xff\x51"sv, RasterFormat::kJpeg2000},  // a codestream without boxes around it
    {"\x76\x2f\x31\x01"sv, RasterFormat::kOpenExr},
    {"#?RADIANCE"sv, RasterFormat::kRadiance},
    {"#?RGBE"sv, RasterFormat::kRadiance},
};

// What is known of a file before anything is decoded.
struct Evidence {
  std::string head;  // its first bytes
  std::uint64_t size = 0;
  std::filesystem::path path;

  [[nodiscard]] bool has(std::size_t at, std::string_view bytes) const {
    return head.size() >= at + bytes.size() && std::string_view(head).substr(at, bytes.size()) == bytes;
  }
  [[nodiscard]] std::string suffix() const { return lower(path.extension().string()); }
  // The head without white space at its start, in lower case.
  [[nodiscard]] std::string text() const {
    const std::size_t begin = std::min(head.find_first_not_of(" \t\r\n\xef\xbb\xbf"), head.size());
    return lower(head.substr(begin));
  }
  static std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
  }
};

Result<Evidence> gather(const FileBytes& file) {
  Evidence evidence{.head = std::string(kHeadBytes, '\0'), .size = file.size(), .path = file.path()};
  VT_ASSIGN(const std::size_t got, file.read_some(0, std::as_writable_bytes(std::span(evidence.head))));
  evidence.head.resize(got);
  return evidence;
}

std::optional<RasterFormat> read_format(const Evidence& evidence) {
  for (const ReadRow& row : kReadMagic)
    if (evidence.has(0, row.bytes)) return row.format;
  const std::string& head = evidence.head;
  const bool is_pnm = head.size() > 2 && head[0] == 'P' && head[1] >= '1' && head[1] <= '6' &&
                      (std::isspace(static_cast<unsigned char>(head[2])) != 0 || head[2] == '#');
  return is_pnm ? std::optional(RasterFormat::kPnm) : std::nullopt;
}

// Square tiles of 16-bit heights: nothing but their size and name tells them.
bool is_hgt(const Evidence& evidence) {
  constexpr std::array<std::uint64_t, 4> kEdges = {1201, 1801, 3601, 7201};
  const bool has_size = std::ranges::any_of(kEdges, [&](std::uint64_t edge) { return evidence.size == 2 * edge * edge; });
  const std::string name = Evidence::lower(evidence.path.stem().string());
  const bool has_name = name.size() >= 7 && (name[0] == 'n' || name[0] == 's') && (name[3] == 'e' || name[3] == 'w') &&
                        std::ranges::all_of(name.substr(1, 2) + name.substr(4, 3), [](unsigned char c) { return std::isdigit(c) != 0; });
  return evidence.suffix() == ".hgt" || (has_size && has_name);
}

// As GDAL knows them: two numbers at fixed places of the first record.
bool is_usgs_dem(const Evidence& evidence) {
  constexpr std::array<std::string_view, 5> kLevels = {"     0"sv, "     1"sv, "     2"sv, "     3"sv, " -9999"sv};
  constexpr std::array<std::string_view, 2> kPatterns = {"     1"sv, "     4"sv};
  return std::ranges::any_of(kLevels, [&](std::string_view level) { return evidence.has(156, level); }) &&
         std::ranges::any_of(kPatterns, [&](std::string_view pattern) { return evidence.has(150, pattern); });
}

// Samples without any header of their own, described by a text file beside them.
bool has_raw_header(const Evidence& evidence) {
  for (const char* suffix : {".hdr", ".HDR"}) {
    for (const std::filesystem::path& header :
         {std::filesystem::path(evidence.path).replace_extension(suffix), std::filesystem::path(evidence.path.string() + suffix)}) {
      std::error_code error;
      if (header != evidence.path && std::filesystem::is_regular_file(header, error)) return true;
    }
  }
  return false;
}

std::optional<Foreign> foreign_format(const Evidence& evidence) {
  if (is_hgt(evidence)) return Foreign{"SRTM height tile (HGT)", Advice::kTranslate};  // its first heights may be anything
  for (const MagicRow& row : kForeignMagic)
    if (evidence.has(row.at, row.bytes)) return row.format;
  const std::string text = evidence.text();
  const auto begins = [&](std::string_view words) { return text.starts_with(words); };
  if (begins("ncols") || begins("nrows")) {
    // Headers of BIL files begin with the same words, but their first samples are elsewhere.
    const bool is_header = evidence.suffix() == ".hdr" || text.find("byteorder") != std::string::npos;
    if (!is_header) return Foreign{"ASCII grid (Arc/Info)", Advice::kTranslate};
  }
  if (begins("north:") || begins("south:")) return Foreign{"ASCII grid (GRASS)", Advice::kTranslate};
  if (begins("<vrtdataset") || (begins("<?xml") && text.find("<vrtdataset") != std::string::npos))
    return Foreign{"GDAL virtual raster (VRT)", Advice::kTranslate};
  if (begins("<gdal_wms") || begins("<mrf_meta")) return Foreign{"description of a raster elsewhere, for GDAL", Advice::kTranslate};
  if (begins("<?xml") || begins("<kml")) return Foreign{"XML document", Advice::kNoRaster};
  if (begins("{") || begins("[")) return Foreign{"JSON document", Advice::kNoRaster};
  const bool describes_raw = begins("envi") || begins("byteorder") || begins("layout") || begins("ncols") || begins("nrows");
  if (evidence.suffix() == ".hdr" && describes_raw) return Foreign{"header of a raw raster (ENVI, BIL), not the raster", Advice::kNoRaster};
  if (evidence.suffix() == ".ecw") return Foreign{"ECW raster", Advice::kTranslate};
  if (evidence.suffix() == ".sid") return Foreign{"MrSID raster", Advice::kTranslate};
  if (is_usgs_dem(evidence)) return Foreign{"USGS DEM", Advice::kTranslate};
  if (has_raw_header(evidence)) return Foreign{"raw raster (BIL, BIP, BSQ, ENVI) with a header beside it", Advice::kTranslate};
  if (evidence.suffix() == ".tga") return Foreign{"TGA picture", Advice::kPicture};
  return std::nullopt;
}

std::string advice_for(const Foreign& format, const std::string& name) {
  switch (format.advice) {
    case Advice::kTranslate:
      return fmt::format("; GDAL makes a GeoTIFF of it: gdal_translate {} new.tif", name);
    case Advice::kVariable:
      return fmt::format("; gdalinfo {} lists the rasters in it, and gdal_translate SUBDATASET_NAME new.tif makes a GeoTIFF of one", name);
    case Advice::kPicture:
      return fmt::format("; save it as PNG, or make a TIFF of it: gdal_translate {} new.tif", name);
    case Advice::kUnpack:
      return "; unpack it first";
    case Advice::kNoRaster:
      return "";
  }
  return "";
}

// The first bytes, for formats that nobody knows.
std::string bytes_text(const std::string& head) {
  std::string text;
  for (const char c : head.substr(0, 8)) text += fmt::format("{}{:02x}", text.empty() ? "" : " ", static_cast<unsigned char>(c));
  return text;
}

}  // namespace

Result<RasterFormat> identify(const FileBytes& file) {
  VT_ASSIGN(const Evidence evidence, gather(file));
  const std::string path = file.path().string();
  if (evidence.head.empty()) return fail(ErrorCode::kInvalidData, path + ": the file is empty");
  if (const auto format = read_format(evidence)) return *format;
  if (const auto foreign = foreign_format(evidence))
    return fail(ErrorCode::kUnsupported, fmt::format("{}: is in a format that is not read, {}{}", path, foreign->name,
                                                     advice_for(*foreign, file.path().filename().string())));
  return fail(ErrorCode::kUnsupported,
              fmt::format("{}: the content is of no format that is read, which are {}; it begins with the bytes {}", path, kReadFormats,
                          bytes_text(evidence.head)));
}

Result<std::string> foreign_name(const FileBytes& file) {
  VT_ASSIGN(const Evidence evidence, gather(file));
  if (read_format(evidence)) return std::string();
  const auto foreign = foreign_format(evidence);
  const bool is_raster = foreign && foreign->advice != Advice::kUnpack && foreign->advice != Advice::kNoRaster;
  return is_raster ? std::string(foreign->name) : std::string();
}

}  // namespace vt::source
