#include "builder/source/tiff/geotiff_writer.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "builder/geo/geo_keys.h"
#include "builder/source/metadata/geo_tags.h"
#include "store/io/output_file.h"

namespace vt::source {
namespace {

// Classic TIFF ends at 4 GiB; incompressible data grow a little and tables come on top.
constexpr double kClassicLimitBytes = 4.0e9;
constexpr std::int64_t kMaxBufferBytes = std::int64_t{1} << 30;

void register_geo_tags(TIFF* tiff) {
  static char names[][24] = {"ModelPixelScale", "ModelTiepoint",  "ModelTransformation", "GeoKeyDirectory",
                             "GeoDoubleParams", "GeoAsciiParams", "GDALNoData"};
  static const TIFFFieldInfo kFields[] = {
      {kModelPixelScale, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[0]},
      {kModelTiepoint, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[1]},
      {kModelTransformation, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[2]},
      {kGeoKeyDirectory, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, names[3]},
      {kGeoDoubleParams, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[4]},
      {kGeoAsciiParams, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, names[5]},
      {kGdalNodata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, names[6]},
  };
  TIFFMergeFieldInfo(tiff, kFields, static_cast<std::uint32_t>(std::size(kFields)));
}

bool is_float(SampleType type) { return type == SampleType::kFloat32 || type == SampleType::kFloat64; }
bool is_signed(SampleType type) { return type == SampleType::kInt8 || type == SampleType::kInt16 || type == SampleType::kInt32; }

std::string nodata_text(double value) {
  if (std::isnan(value)) return "nan";
  return fmt::format("{}", value);  // shortest text that reads back as the same number; inf and -inf by name
}

}  // namespace

struct GeoTiffWriter::Impl {
  std::filesystem::path path;
  std::optional<store::OutputFile> file;
  std::uint64_t file_at = 0;  // where libtiff reads and writes next
  GeoTiffSpec spec;
  TIFF* tiff = nullptr;
  std::string error;

  std::size_t pixel_bytes = 0;
  std::size_t row_bytes = 0;
  std::int64_t block_rows = 0;     // of a row of tiles, or a strip
  std::int64_t rows_written = 0;   // handed over to libtiff
  std::int64_t rows_buffered = 0;  // waiting in `buffer`
  std::vector<std::byte> buffer;   // one row of tiles, or one strip
  std::vector<std::byte> tile;

  ~Impl() {
    if (tiff != nullptr) TIFFClose(tiff);  // the file goes with `file`
  }

  static int on_error(TIFF*, void* self, const char*, const char* format, va_list arguments) {
    auto& impl = *static_cast<Impl*>(self);
    std::array<char, 512> text{};
    std::vsnprintf(text.data(), text.size(), format, arguments);
    if (impl.error.empty()) impl.error = text.data();
    return 1;
  }
  static int on_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

  // How libtiff reaches the file. What fails there is kept by the file itself.
  static tmsize_t read(thandle_t self, void* out, tmsize_t bytes) {
    auto& impl = *static_cast<Impl*>(self);
    const auto got = impl.file->read_at(impl.file_at, {static_cast<std::byte*>(out), static_cast<std::size_t>(bytes)});
    if (!got) return -1;
    impl.file_at += *got;
    return static_cast<tmsize_t>(*got);
  }
  static tmsize_t write(thandle_t self, void* from, tmsize_t bytes) {
    auto& impl = *static_cast<Impl*>(self);
    if (!impl.file->write_at(impl.file_at, {static_cast<const std::byte*>(from), static_cast<std::size_t>(bytes)})) return -1;
    impl.file_at += static_cast<std::uint64_t>(bytes);
    return bytes;
  }
  static toff_t seek(thandle_t self, toff_t offset, int whence) {
    auto& impl = *static_cast<Impl*>(self);
    // libtiff gives negative offsets as what they wrap around to.
    impl.file_at = whence == SEEK_SET ? offset : (whence == SEEK_END ? impl.file->size() : impl.file_at) + offset;
    return impl.file_at;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t self) { return static_cast<Impl*>(self)->file->size(); }

  [[nodiscard]] tl::unexpected<Error> refused() const {
    if (file->failure()) return tl::unexpected(*file->failure());
    return fail(ErrorCode::kIo, fmt::format("{}: cannot write it: {}", path.string(), error.empty() ? "libtiff does not say why" : error));
  }

  [[nodiscard]] Result<void> open();
  [[nodiscard]] Result<void> set_tags();
  [[nodiscard]] Result<void> set_compression();
  [[nodiscard]] bool set_place();
  [[nodiscard]] Result<void> flush_buffer();
  [[nodiscard]] Result<void> write_tiles(std::int64_t rows);
};

Result<void> GeoTiffWriter::Impl::open() {
  const double data_bytes = static_cast<double>(row_bytes) * static_cast<double>(spec.height);
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, &Impl::on_error, this);
  TIFFOpenOptionsSetWarningHandlerExtR(options, &Impl::on_warning, this);
  tiff = TIFFClientOpenExt(path.c_str(), data_bytes > kClassicLimitBytes ? "w8m" : "wm", this, &Impl::read, &Impl::write, &Impl::seek,
                           &Impl::close, &Impl::size, nullptr, nullptr, options);
  TIFFOpenOptionsFree(options);
  if (tiff == nullptr) return refused();
  register_geo_tags(tiff);
  return set_tags();
}

Result<void> GeoTiffWriter::Impl::set_tags() {
  const int bands = spec.bands;
  const int colors = bands - (spec.last_band_is_alpha ? 1 : 0);
  const bool is_rgb = (spec.sample_type == SampleType::kUint8 || spec.sample_type == SampleType::kUint16) && colors >= 3;
  const bool is_jpeg = spec.compression == GeoTiffSpec::Compression::kJpeg;
  const int photometric = is_jpeg && bands == 3 ? PHOTOMETRIC_YCBCR : (is_rgb ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  const int extra_count = bands - (is_rgb ? 3 : 1);
  bool ok = TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(spec.width)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(spec.height)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, bands) == 1 &&
            TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sample_bytes(spec.sample_type))) == 1 &&
            TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
                         is_float(spec.sample_type) ? SAMPLEFORMAT_IEEEFP
                                                    : (is_signed(spec.sample_type) ? SAMPLEFORMAT_INT : SAMPLEFORMAT_UINT)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == 1 && TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, photometric) == 1;
  if (extra_count > 0) {
    std::vector<std::uint16_t> extra(static_cast<std::size_t>(extra_count), EXTRASAMPLE_UNSPECIFIED);
    if (spec.last_band_is_alpha) extra.back() = EXTRASAMPLE_UNASSALPHA;
    ok = ok && TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, extra_count, extra.data()) == 1;
  }
  if (spec.tile > 0) {
    ok = ok && TIFFSetField(tiff, TIFFTAG_TILEWIDTH, spec.tile) == 1 && TIFFSetField(tiff, TIFFTAG_TILELENGTH, spec.tile) == 1;
  } else {
    ok = ok && TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, static_cast<std::uint32_t>(block_rows)) == 1;
  }
  if (!ok) return refused();
  VT_CHECK(set_compression());
  if (!set_place()) return refused();
  return {};
}

Result<void> GeoTiffWriter::Impl::set_compression() {
  using Compression = GeoTiffSpec::Compression;
  std::uint16_t code = COMPRESSION_NONE;
  bool predicts = false;
  switch (spec.compression) {
    case Compression::kNone:
      break;
    case Compression::kDeflate:
      code = COMPRESSION_ADOBE_DEFLATE, predicts = true;
      break;
    case Compression::kLzw:
      code = COMPRESSION_LZW, predicts = true;
      break;
    case Compression::kZstd:
      code = COMPRESSION_ZSTD, predicts = true;
      break;
    case Compression::kJpeg:
      code = COMPRESSION_JPEG;
      break;
  }
  if (TIFFIsCODECConfigured(code) == 0)
    return fail(ErrorCode::kUnsupported, fmt::format("{}: this libtiff has no encoder for compression {}", path.string(), code));
  bool ok = TIFFSetField(tiff, TIFFTAG_COMPRESSION, code) == 1;
  if (predicts)
    ok = ok && TIFFSetField(tiff, TIFFTAG_PREDICTOR, is_float(spec.sample_type) ? PREDICTOR_FLOATINGPOINT : PREDICTOR_HORIZONTAL) == 1;
  if (code == COMPRESSION_JPEG && spec.bands == 3) ok = ok && TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB) == 1;
  if (!ok) return refused();
  return {};
}

bool GeoTiffWriter::Impl::set_place() {
  bool ok = true;
  if (spec.transform) {
    const geo::GeoTransform& t = *spec.transform;
    if (t.is_north_up()) {
      const std::array<double, 3> scale{t.x_column, -t.y_row, 0.0};
      const std::array<double, 6> tie{0.0, 0.0, 0.0, t.x0, t.y0, 0.0};
      ok = ok && TIFFSetField(tiff, kModelPixelScale, 3, scale.data()) == 1 && TIFFSetField(tiff, kModelTiepoint, 6, tie.data()) == 1;
    } else {
      const std::array<double, 16> matrix{t.x_column, t.x_row, 0.0, t.x0, t.y_column, t.y_row, 0.0, t.y0,
                                          0.0,        0.0,     0.0, 0.0,  0.0,        0.0,     0.0, 1.0};
      ok = ok && TIFFSetField(tiff, kModelTransformation, 16, matrix.data()) == 1;
    }
  }
  if (spec.crs) {
    const geo::GeoKeyTags keys = geo::geo_keys_from_crs(*spec.crs);
    ok = ok && TIFFSetField(tiff, kGeoKeyDirectory, static_cast<int>(keys.directory.size()), keys.directory.data()) == 1;
    if (!keys.doubles.empty())
      ok = ok && TIFFSetField(tiff, kGeoDoubleParams, static_cast<int>(keys.doubles.size()), keys.doubles.data()) == 1;
    if (!keys.ascii.empty()) ok = ok && TIFFSetField(tiff, kGeoAsciiParams, keys.ascii.c_str()) == 1;
  }
  if (spec.nodata) ok = ok && TIFFSetField(tiff, kGdalNodata, nodata_text(*spec.nodata).c_str()) == 1;
  return ok;
}

Result<void> GeoTiffWriter::Impl::write_tiles(std::int64_t rows) {
  const std::int64_t side = spec.tile;
  const std::size_t tile_row_bytes = static_cast<std::size_t>(side) * pixel_bytes;
  tile.resize(tile_row_bytes * static_cast<std::size_t>(side));
  for (std::int64_t x = 0; x < spec.width; x += side) {
    const std::int64_t columns = std::min(side, spec.width - x);
    for (std::int64_t row = 0; row < side; ++row) {
      // What sticks out repeats the last row and column: JPEG then has no edge to ring at.
      const std::byte* in =
          buffer.data() + static_cast<std::size_t>(std::min(row, rows - 1)) * row_bytes + static_cast<std::size_t>(x) * pixel_bytes;
      std::byte* out = tile.data() + static_cast<std::size_t>(row) * tile_row_bytes;
      std::memcpy(out, in, static_cast<std::size_t>(columns) * pixel_bytes);
      for (std::int64_t column = columns; column < side; ++column) {
        std::memcpy(out + static_cast<std::size_t>(column) * pixel_bytes, in + static_cast<std::size_t>(columns - 1) * pixel_bytes,
                    pixel_bytes);
      }
    }
    const std::uint32_t index = TIFFComputeTile(tiff, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(rows_written), 0, 0);
    if (TIFFWriteEncodedTile(tiff, index, tile.data(), static_cast<tmsize_t>(tile.size())) < 0) return refused();
  }
  return {};
}

Result<void> GeoTiffWriter::Impl::flush_buffer() {
  if (rows_buffered == 0) return {};
  if (spec.tile > 0) {
    VT_CHECK(write_tiles(rows_buffered));
  } else {
    const auto strip = static_cast<std::uint32_t>(rows_written / block_rows);
    const auto bytes = static_cast<tmsize_t>(static_cast<std::size_t>(rows_buffered) * row_bytes);
    if (TIFFWriteEncodedStrip(tiff, strip, buffer.data(), bytes) < 0) return refused();
  }
  rows_written += rows_buffered;
  rows_buffered = 0;
  return {};
}

GeoTiffWriter::GeoTiffWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GeoTiffWriter::GeoTiffWriter(GeoTiffWriter&&) noexcept = default;
GeoTiffWriter& GeoTiffWriter::operator=(GeoTiffWriter&&) noexcept = default;
GeoTiffWriter::~GeoTiffWriter() = default;

Result<GeoTiffWriter> GeoTiffWriter::create(const std::filesystem::path& path, const GeoTiffSpec& spec) {
  const auto wrong = [&](const std::string& what) { return fail(ErrorCode::kUsage, fmt::format("{}: {}", path.string(), what)); };
  constexpr std::int64_t kMaxSide = std::int64_t{1} << 31;
  if (spec.width < 1 || spec.height < 1 || spec.width >= kMaxSide || spec.height >= kMaxSide) {
    return wrong(fmt::format("a TIFF cannot be {} x {}", spec.width, spec.height));
  }
  if (spec.bands < 1 || spec.bands > 4096) return wrong(fmt::format("a TIFF cannot have {} bands", spec.bands));
  if (spec.tile < 0 || spec.tile % 16 != 0 || spec.tile > 16384)
    return wrong(fmt::format("tiles are multiples of 16 up to 16384 wide, not {}", spec.tile));
  if (spec.tile == 0 && spec.rows_per_strip < 1) return wrong("strips need at least one row");
  if (spec.compression == GeoTiffSpec::Compression::kJpeg &&
      (spec.sample_type != SampleType::kUint8 || (spec.bands != 1 && spec.bands != 3) || spec.last_band_is_alpha || spec.width > 65500)) {
    return wrong("JPEG takes 8-bit samples, one or three bands and no alpha");
  }

  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->spec = spec;
  impl->pixel_bytes = sample_bytes(spec.sample_type) * static_cast<std::size_t>(spec.bands);
  impl->row_bytes = impl->pixel_bytes * static_cast<std::size_t>(spec.width);
  impl->block_rows = spec.tile > 0 ? spec.tile : std::min(spec.rows_per_strip, spec.height);
  if (spec.tile == 0 && spec.compression == GeoTiffSpec::Compression::kJpeg) {
    impl->block_rows = std::min((impl->block_rows + 15) / 16 * 16, spec.height);  // whole rows of JPEG's own 16 x 16 units
  }
  if (static_cast<std::int64_t>(impl->row_bytes) > kMaxBufferBytes / impl->block_rows) {
    return wrong(fmt::format("one row of blocks is larger than {} MB; use smaller tiles or strips", kMaxBufferBytes >> 20));
  }
  impl->buffer.resize(impl->row_bytes * static_cast<std::size_t>(impl->block_rows));
  VT_ASSIGN(impl->file, store::OutputFile::create(path));
  VT_CHECK(impl->open());
  return GeoTiffWriter(std::move(impl));
}

Result<void> GeoTiffWriter::write_rows(std::span<const std::byte> samples, std::int64_t rows) {
  Impl& w = *impl_;
  const std::int64_t left = w.spec.height - w.rows_written - w.rows_buffered;
  if (rows < 0 || rows > left || samples.size() != static_cast<std::size_t>(rows) * w.row_bytes) {
    return fail(ErrorCode::kUsage, fmt::format("{}: {} rows of {} bytes in {} bytes, {} rows are still to come", w.path.string(), rows,
                                               w.row_bytes, samples.size(), left));
  }
  while (rows > 0) {
    const std::int64_t take = std::min(rows, w.block_rows - w.rows_buffered);
    const std::size_t bytes = static_cast<std::size_t>(take) * w.row_bytes;
    std::memcpy(w.buffer.data() + static_cast<std::size_t>(w.rows_buffered) * w.row_bytes, samples.data(), bytes);
    samples = samples.subspan(bytes);
    rows -= take;
    w.rows_buffered += take;
    if (w.rows_buffered == w.block_rows) VT_CHECK(w.flush_buffer());
  }
  return {};
}

Result<void> GeoTiffWriter::finish() {
  Impl& w = *impl_;
  VT_CHECK(w.flush_buffer());
  if (w.rows_written != w.spec.height) {
    return fail(ErrorCode::kUsage, fmt::format("{}: {} of {} rows were written", w.path.string(), w.rows_written, w.spec.height));
  }
  if (TIFFWriteDirectory(w.tiff) != 1 || !w.error.empty()) return w.refused();
  TIFFClose(w.tiff);
  w.tiff = nullptr;
  return w.file->finish();
}

}  // namespace vt::source
