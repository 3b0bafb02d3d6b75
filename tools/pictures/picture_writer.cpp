#include "tools/pictures/picture_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "builder/source/picture/picture_module.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "tools/pictures/picture_writer_module.h"

namespace vt::cli {

namespace {

class GeoTiffPicture : public PictureWriter {
 public:
  explicit GeoTiffPicture(source::GeoTiffWriter writer) : writer_(std::move(writer)) {}
  Result<void> write_rows(std::span<const std::byte> texels, std::int64_t rows) override { return writer_.write_rows(texels, rows); }
  Result<void> finish() override { return writer_.finish(); }

 private:
  source::GeoTiffWriter writer_;
};

Result<std::unique_ptr<PictureWriter>> create_geotiff(const std::filesystem::path& path, const PictureSpec& spec) {
  source::GeoTiffSpec tiff;
  tiff.width = spec.width;
  tiff.height = spec.height;
  tiff.bands = spec.channels;
  tiff.sample_type = spec.is_float ? SampleType::kFloat32 : SampleType::kUint8;
  tiff.last_band_is_alpha = spec.last_is_alpha;
  tiff.nodata = spec.nodata;
  tiff.transform = spec.transform;
  tiff.crs = spec.crs;
  tiff.compression = source::GeoTiffSpec::Compression::kDeflate;
  VT_ASSIGN(source::GeoTiffWriter writer, source::GeoTiffWriter::create(path, tiff));
  return std::make_unique<GeoTiffPicture>(std::move(writer));
}

// From the library that holds all of OpenImageIO, loaded when the first such picture is written.
Result<std::unique_ptr<PictureWriter>> create_with_openimageio(const std::filesystem::path& path, const PictureSpec& spec) {
  VT_ASSIGN(const void* const symbol, source::picture_library_symbol(kPictureWriterModuleSymbol));
  return static_cast<const PictureWriterModule*>(symbol)->create(path, spec);
}

}  // namespace

Result<PictureKind> picture_kind(const std::filesystem::path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (suffix == ".png") return PictureKind::kPng;
  if (suffix == ".exr") return PictureKind::kExr;
  if (suffix == ".tif" || suffix == ".tiff") return PictureKind::kTiff;
  return fail(ErrorCode::kUsage, fmt::format("{}: found suffix \"{}\", wanted .png, .exr or .tif", path.string(), suffix));
}

Result<std::unique_ptr<PictureWriter>> create_picture(const std::filesystem::path& path, const PictureSpec& spec) {
  VT_ASSIGN(const PictureKind kind, picture_kind(path));
  return kind == PictureKind::kTiff ? create_geotiff(path, spec) : create_with_openimageio(path, spec);
}

}  // namespace vt::cli
