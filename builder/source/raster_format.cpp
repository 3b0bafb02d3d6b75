#include "builder/source/raster_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <vector>

#include "builder/source/formats/ascii_grid.h"
#include "builder/source/picture/picture_source.h"
#include "builder/source/tiff/geotiff_source.h"

namespace vt::source {
namespace {

using namespace std::string_view_literals;

template <const PictureFormat& kFormat>
Result<std::unique_ptr<RasterSource>> open_as(std::shared_ptr<const FileBytes> file, const OpenOptions& options) {
  return open_picture(std::move(file), kFormat, options);
}

bool is_pnm(const FileEvidence& file) {
  const std::string& head = file.head;
  return head.size() > 2 && head[0] == 'P' && head[1] >= '1' && head[1] <= '6' &&
         (std::isspace(static_cast<unsigned char>(head[2])) != 0 || head[2] == '#');
}

// Square tiles of 16-bit heights: nothing but their size and name tells them.
bool is_hgt(const FileEvidence& file) {
  constexpr std::array<std::uint64_t, 4> kEdges = {1201, 1801, 3601, 7201};
  const bool has_size = std::ranges::any_of(kEdges, [&](std::uint64_t edge) { return file.size == 2 * edge * edge; });
  const std::string name = in_lower_case(file.path.stem().string());
  const bool has_name = name.size() >= 7 && (name[0] == 'n' || name[0] == 's') && (name[3] == 'e' || name[3] == 'w') &&
                        std::ranges::all_of(name.substr(1, 2) + name.substr(4, 3), [](unsigned char c) { return std::isdigit(c) != 0; });
  return file.suffix() == ".hgt" || (has_size && has_name);
}

bool is_grass_grid(const FileEvidence& file) {
  const std::string text = file.text();
  return text.starts_with("north:") || text.starts_with("south:");
}

bool is_vrt(const FileEvidence& file) {
  const std::string text = file.text();
  return text.starts_with("<vrtdataset") || (text.starts_with("<?xml") && text.find("<vrtdataset") != std::string::npos);
}

bool is_gdal_description(const FileEvidence& file) {
  const std::string text = file.text();
  return text.starts_with("<gdal_wms") || text.starts_with("<mrf_meta");
}

bool is_xml(const FileEvidence& file) {
  const std::string text = file.text();
  return text.starts_with("<?xml") || text.starts_with("<kml");
}

bool is_json(const FileEvidence& file) {
  const std::string text = file.text();
  return text.starts_with("{") || text.starts_with("[");
}

bool is_raw_header(const FileEvidence& file) {
  const std::string text = file.text();
  return file.suffix() == ".hdr" && std::ranges::any_of(std::array{"envi", "byteorder", "layout", "ncols", "nrows"},
                                                        [&](const char* word) { return text.starts_with(word); });
}

bool is_ecw(const FileEvidence& file) { return file.suffix() == ".ecw"; }
bool is_mrsid(const FileEvidence& file) { return file.suffix() == ".sid"; }
bool is_tga(const FileEvidence& file) { return file.suffix() == ".tga"; }

// As GDAL knows them: two numbers at fixed places of the first record.
bool is_usgs_dem(const FileEvidence& file) {
  constexpr std::array<std::string_view, 5> kLevels = {"     0"sv, "     1"sv, "     2"sv, "     3"sv, " -9999"sv};
  constexpr std::array<std::string_view, 2> kPatterns = {"     1"sv, "     4"sv};
  return std::ranges::any_of(kLevels, [&](std::string_view level) { return file.has(156, level); }) &&
         std::ranges::any_of(kPatterns, [&](std::string_view pattern) { return file.has(150, pattern); });
}

// Samples without any header of their own, described by a text file beside them.
bool is_raw(const FileEvidence& file) {
  for (const char* suffix : {".hdr", ".HDR"}) {
    for (const std::filesystem::path& header :
         {std::filesystem::path(file.path).replace_extension(suffix), std::filesystem::path(file.path.string() + suffix)}) {
      std::error_code error;
      if (header != file.path && std::filesystem::is_regular_file(header, error)) return true;
    }
  }
  return false;
}

// First what is read; then what is told by its name, whose content may be anything; then numbers and words at
// fixed places; then texts, and last what only a suffix or a neighbour tells.
constexpr RasterFormat kFormats[] = {
    {.name = "GeoTIFF",
     .magic = {{{0, "II*\0"sv}, {0, "MM\0*"sv}, {0, "II+\0"sv}, {0, "MM\0+"sv}}},  // the latter two are BigTIFF
     .suffixes = {".tif", ".tiff", ".gtiff"},
     .open = open_geotiff},
    {.name = "PNG", .magic = {{{0, "\x89PNG\r\n\x1a\n"sv}}}, .suffixes = {".png"}, .open = open_as<kPngFormat>},
    {.name = "JPEG", .magic = {{{0, "\xff\xd8\xff"sv}}}, .suffixes = {".jpg", ".jpeg"}, .open = open_as<kJpegFormat>},
    {.name = "JPEG 2000",
     .magic = {{{0, "\0\0\0\x0cjP  \r\n\x87\n"sv}, {0, "\xff\x4f\xff\x51"sv}}},  // boxes, or a codestream without boxes around it
     .suffixes = {".jp2", ".j2k"},
     .open = open_as<kJpeg2000Format>},
    {.name = "OpenEXR", .magic = {{{0, "\x76\x2f\x31\x01"sv}}}, .suffixes = {".exr"}, .open = open_as<kOpenExrFormat>},
    {.name = "Radiance HDR",
     .magic = {{{0, "#?RADIANCE"sv}, {0, "#?RGBE"sv}}},
     .suffixes = {".hdr"},
     .shares_suffix = true,  // with headers of raw rasters
     .open = open_as<kRadianceFormat>},
    {.name = "PNM (PBM, PGM, PPM)", .is_this = is_pnm, .suffixes = {".ppm", ".pgm", ".pbm", ".pnm"}, .open = open_as<kPnmFormat>},

    {.name = "SRTM height tile (HGT)", .is_this = is_hgt, .suffixes = {".hgt"}, .advice = Advice::kTranslate},
    {.name = "Esri ASCII grid",
     .is_this = is_ascii_grid,
     .suffixes = {".asc"},
     .shares_suffix = true,  // with signatures
     .open = open_ascii_grid},

    {.name = "NITF", .magic = {{{0, "NITF0"sv}}}, .suffixes = {".ntf", ".nitf"}, .advice = Advice::kTranslate},
    {.name = "NSIF", .magic = {{{0, "NSIF0"sv}}}, .advice = Advice::kTranslate},
    {.name = "ERDAS Imagine raster (IMG)", .magic = {{{0, "EHFA_HEADER_TAG"sv}}}, .suffixes = {".img"}, .advice = Advice::kTranslate},
    {.name = "GeoPackage", .magic = {{{68, "GPKG"sv}, {68, "GP10"sv}, {68, "GP11"sv}}}, .advice = Advice::kTranslate},
    {.name = "MBTiles tile set", .magic = {{{68, "MPBX"sv}}}, .advice = Advice::kTranslate},
    {.name = "SQLite database (MBTiles, GeoPackage)", .magic = {{{0, "SQLite format 3\0"sv}}}, .advice = Advice::kTranslate},
    {.name = "PMTiles tile set", .magic = {{{0, "PMTiles"sv}}}, .advice = Advice::kTranslate},
    {.name = "netCDF", .magic = {{{0, "CDF\x01"sv}, {0, "CDF\x02"sv}, {0, "CDF\x05"sv}}}, .suffixes = {".nc"}, .advice = Advice::kVariable},
    {.name = "HDF5 or netCDF-4", .magic = {{{0, "\x89HDF\r\n\x1a\n"sv}}}, .suffixes = {".h5"}, .advice = Advice::kVariable},
    {.name = "HDF4", .magic = {{{0, "\x0e\x03\x13\x01"sv}}}, .suffixes = {".hdf"}, .advice = Advice::kVariable},
    {.name = "GRIB", .magic = {{{0, "GRIB"sv}}}, .suffixes = {".grb", ".grb2", ".grib", ".grib2"}, .advice = Advice::kTranslate},
    {.name = "DTED",
     .magic = {{{0, "UHL1"sv}, {80, "UHL1"sv}, {160, "UHL1"sv}}},
     .suffixes = {".dt0", ".dt1", ".dt2"},
     .advice = Advice::kTranslate},
    {.name = "Surfer grid", .magic = {{{0, "DSAA"sv}, {0, "DSBB"sv}, {0, "DSRB"sv}}}, .advice = Advice::kTranslate},
    {.name = "PCIDSK raster", .magic = {{{0, "PCIDSK  "sv}}}, .suffixes = {".pix"}, .advice = Advice::kTranslate},
    {.name = "Terragen terrain", .magic = {{{0, "TERRAGENTERRAIN "sv}}}, .suffixes = {".ter"}, .advice = Advice::kTranslate},
    {.name = "VTP binary terrain (BT)", .magic = {{{0, "binterr"sv}}}, .suffixes = {".bt"}, .advice = Advice::kTranslate},
    {.name = "LERC blob", .magic = {{{0, "Lerc2 "sv}, {0, "CntZImage "sv}}}, .advice = Advice::kTranslate},
    {.name = "FITS", .magic = {{{0, "SIMPLE  ="sv}}}, .advice = Advice::kTranslate},
    {.name = "SGI picture", .magic = {{{0, "\x01\xda"sv}}}, .advice = Advice::kPicture},
    {.name = "BMP picture", .magic = {{{0, "BM"sv}}}, .suffixes = {".bmp"}, .advice = Advice::kPicture},
    {.name = "GIF picture", .magic = {{{0, "GIF8"sv}}}, .advice = Advice::kPicture},
    {.name = "WebP picture", .magic = {{{8, "WEBP"sv}}}, .suffixes = {".webp"}, .advice = Advice::kPicture},
    {.name = "Photoshop picture (PSD)", .magic = {{{0, "8BPS"sv}}}, .advice = Advice::kPicture},
    {.name = "DDS texture", .magic = {{{0, "DDS "sv}}}, .advice = Advice::kPicture},
    {.name = "KTX texture", .magic = {{{0, "\xabKTX "sv}}}, .advice = Advice::kPicture},
    {.name = "DPX picture", .magic = {{{0, "SDPX"sv}, {0, "XPDS"sv}}}, .advice = Advice::kPicture},
    {.name = "JPEG XL picture", .magic = {{{0, "\xff\x0a"sv}, {4, "JXL \r\n"sv}}}, .advice = Advice::kPicture},
    {.name = "HEIF or AVIF picture", .magic = {{{4, "ftyp"sv}}}, .advice = Advice::kPicture},
    {.name = "PAM picture", .magic = {{{0, "P7\n"sv}}}, .advice = Advice::kPicture},
    {.name = "Windows icon (ICO)", .magic = {{{0, "\0\0\x01\0"sv}}}, .advice = Advice::kPicture},
    {.name = "Windows cursor or TGA picture", .magic = {{{0, "\0\0\x02\0"sv}}}, .advice = Advice::kPicture},
    {.name = "PDF document", .magic = {{{0, "%PDF"sv}}}, .advice = Advice::kTranslate},
    {.name = "ZIP archive", .magic = {{{0, "PK\x03\x04"sv}}}, .advice = Advice::kUnpack},
    {.name = "gzip archive", .magic = {{{0, "\x1f\x8b"sv}}}, .advice = Advice::kUnpack},
    {.name = "bzip2 archive", .magic = {{{0, "BZh"sv}}}, .advice = Advice::kUnpack},
    {.name = "xz archive",
     .magic = {{{0,
                 "\xfd"
                 "7zXZ"sv}}},
     .advice = Advice::kUnpack},
    {.name = "7-Zip archive", .magic = {{{0, "7z\xbc\xaf"sv}}}, .advice = Advice::kUnpack},
    {.name = "tar archive", .magic = {{{257, "ustar"sv}}}, .advice = Advice::kUnpack},
    {.name = "LAS point cloud", .magic = {{{0, "LASF"sv}}}, .advice = Advice::kNoRaster},
    {.name = "shapefile", .magic = {{{0, "\0\0\x27\x0a"sv}}}, .advice = Advice::kNoRaster},
    {.name = "tile store, which this program writes", .magic = {{{0, "VTSTORE1"sv}}}, .advice = Advice::kNoRaster},

    {.name = "ASCII grid (GRASS)", .is_this = is_grass_grid, .advice = Advice::kTranslate},
    {.name = "GDAL virtual raster (VRT)", .is_this = is_vrt, .advice = Advice::kTranslate},
    {.name = "description of a raster elsewhere, for GDAL", .is_this = is_gdal_description, .advice = Advice::kTranslate},
    {.name = "XML document", .is_this = is_xml, .advice = Advice::kNoRaster},
    {.name = "JSON document", .is_this = is_json, .advice = Advice::kNoRaster},
    {.name = "header of a raw raster (ENVI, BIL), not the raster", .is_this = is_raw_header, .advice = Advice::kNoRaster},
    {.name = "ECW raster", .is_this = is_ecw, .suffixes = {".ecw"}, .advice = Advice::kTranslate},
    {.name = "MrSID raster", .magic = {{{0, "msid"sv}}}, .is_this = is_mrsid, .suffixes = {".sid"}, .advice = Advice::kTranslate},
    {.name = "USGS DEM", .is_this = is_usgs_dem, .suffixes = {".dem"}, .advice = Advice::kTranslate},
    {.name = "raw raster (BIL, BIP, BSQ, ENVI) with a header beside it",
     .is_this = is_raw,
     .suffixes = {".bil", ".bip", ".bsq", ".flt"},
     .advice = Advice::kTranslate},
    {.name = "TGA picture", .is_this = is_tga, .suffixes = {".tga"}, .advice = Advice::kPicture},
};

bool is_of(const RasterFormat& format, const FileEvidence& file) {
  const bool has_magic =
      std::ranges::any_of(format.magic, [&](const Magic& magic) { return !magic.bytes.empty() && file.has(magic.at, magic.bytes); });
  return has_magic || (format.is_this != nullptr && format.is_this(file));
}

const RasterFormat* format_of(const FileEvidence& file) {
  const auto* const found = std::ranges::find_if(kFormats, [&](const RasterFormat& format) { return is_of(format, file); });
  return found != std::end(kFormats) ? found : nullptr;
}

std::string advice_for(const RasterFormat& format, const std::string& name) {
  switch (format.advice) {
    case Advice::kTranslate:
      return fmt::format("; GDAL makes a GeoTIFF of it: gdal_translate {} new.tif", name);
    case Advice::kVariable:
      return fmt::format("; gdalinfo {} lists the rasters in it, and gdal_translate SUBDATASET_NAME new.tif makes a GeoTIFF of one", name);
    case Advice::kPicture:
      return fmt::format("; save it as PNG, or make a TIFF of it: gdal_translate {} new.tif", name);
    case Advice::kUnpack:
      return "; unpack it first";
    case Advice::kNone:
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

std::string names_of_read_formats() {
  std::vector<std::string_view> names;
  for (const RasterFormat& format : kFormats)
    if (format.open != nullptr) names.push_back(format.name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} and {}", fmt::join(names, ", "), last);
}

bool RasterFormat::has_suffix(const std::filesystem::path& path) const {
  const std::string suffix = in_lower_case(path.extension().string());
  return !suffix.empty() && std::ranges::find(suffixes, suffix) != suffixes.end();
}

std::span<const RasterFormat> raster_formats() { return kFormats; }

Result<const RasterFormat*> format_of(const FileBytes& file) {
  VT_ASSIGN(const FileEvidence evidence, FileEvidence::of(file));
  return format_of(evidence);
}

Result<const RasterFormat*> identify(const FileBytes& file) {
  VT_ASSIGN(const FileEvidence evidence, FileEvidence::of(file));
  const std::string path = file.path().string();
  if (evidence.head.empty()) return fail(ErrorCode::kInvalidData, path + ": the file is empty");
  const RasterFormat* const format = format_of(evidence);
  if (format == nullptr)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: the content is of no format that is read, which are {}; it begins with the bytes {}", path,
                            names_of_read_formats(), bytes_text(evidence.head)));
  if (format->open == nullptr)
    return fail(ErrorCode::kUnsupported, fmt::format("{}: is in a format that is not read, {}{}", path, format->name,
                                                     advice_for(*format, file.path().filename().string())));
  return format;
}

Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path, const OpenOptions& options) {
  VT_ASSIGN(auto file, FileBytes::open(path, options.files));
  VT_ASSIGN(const RasterFormat* const format, identify(*file));
  return format->open(std::move(file), options);
}

}  // namespace vt::source
