#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "builder/source/cells/cell_store.h"
#include "builder/source/files/file_bytes.h"
#include "builder/source/metadata/gdal_metadata.h"
#include "builder/source/picture/picture_header.h"
#include "builder/source/picture/picture_module.h"
#include "builder/source/source_common.h"
#include "builder/source/tiff/masked_source.h"

namespace vt::source {
namespace {

// OpenEXR compresses up to so many rows together; bands of scanlines begin and end with them.
constexpr std::int64_t kRowsCompressedTogether = 32;

std::optional<SampleType> sample_type_of(const OIIO::ImageSpec& spec) {
  if (!spec.channelformats.empty()) return SampleType::kFloat32;  // OpenEXR channels of several types
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      return SampleType::kUint8;
    case OIIO::TypeDesc::INT8:
      return SampleType::kInt8;
    case OIIO::TypeDesc::UINT16:
      return SampleType::kUint16;
    case OIIO::TypeDesc::INT16:
      return SampleType::kInt16;
    case OIIO::TypeDesc::UINT32:
      return SampleType::kUint32;
    case OIIO::TypeDesc::INT32:
      return SampleType::kInt32;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      return SampleType::kFloat32;
    case OIIO::TypeDesc::DOUBLE:
      return SampleType::kFloat64;
    default:
      return std::nullopt;
  }
}

OIIO::TypeDesc oiio_type(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::kInt8:
      return OIIO::TypeDesc::INT8;
    case SampleType::kUint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::kInt16:
      return OIIO::TypeDesc::INT16;
    case SampleType::kUint32:
      return OIIO::TypeDesc::UINT32;
    case SampleType::kInt32:
      return OIIO::TypeDesc::INT32;
    case SampleType::kFloat32:
      return OIIO::TypeDesc::FLOAT;
    case SampleType::kFloat64:
      return OIIO::TypeDesc::DOUBLE;
  }
  return OIIO::TypeDesc::UNKNOWN;
}

// One decoder. Most formats decode from the top only, so it matters which row comes next.
struct Input final : IdleReader {
  OIIO::ImageInput::unique_ptr decoder;
  std::int64_t next_row = 0;
};

// By the reader of the format that the content is of, and by no other: asked for a file alone, OpenImageIO
// tries all that it has.
Result<std::unique_ptr<Input>> open_input(const FileBytes& file, const PictureFormat& format) {
  VT_CHECK(file.check_unchanged());  // OpenImageIO opens it by its path
  const std::string path = file.path().string();
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);  // codes as they are in the file
  auto input = std::make_unique<Input>();
  input->decoder = OIIO::ImageInput::create(format.reader);
  if (!input->decoder)
    return fail(ErrorCode::kInternal, fmt::format("{}: OpenImageIO lacks its reader \"{}\": {}", path, format.reader, OIIO::geterror()));
  std::string reason;
  try {
    OIIO::ImageSpec spec;
    if (input->decoder->open(path, spec, wish)) return input;
    reason = input->decoder->geterror();
  } catch (const std::exception& problem) {  // OpenEXR and lack of memory
    reason = problem.what();
  }
  return fail(ErrorCode::kInvalidData, fmt::format("{}: cannot be read as {}: {}", path, format.reader, reason));
}

// What a PNG's header says of its samples; empty for other files.
struct PngHeader {
  int bits = 8;
  bool has_palette = false;
  bool is_interlaced = false;
};
Result<std::optional<PngHeader>> read_png_header(const FileBytes& file) {
  std::array<std::byte, 29> head{};
  VT_ASSIGN(const std::size_t got, file.read_some(0, head));
  const auto code = [&](std::size_t at) { return std::to_integer<int>(head[at]); };
  const bool is_png = got == head.size() && code(0) == 0x89 && code(1) == 'P' && code(2) == 'N' && code(3) == 'G';
  if (!is_png) return std::optional<PngHeader>{};
  return std::optional(PngHeader{.bits = code(24), .has_palette = code(25) == 3, .is_interlaced = code(28) == 1});
}

Result<store::ContentHash> hash_file(const FileBytes& file) {
  store::ContentHasher hasher;
  Block buffer(std::size_t{1} << 20);
  for (std::uint64_t at = 0; at < file.size(); at += buffer.size()) {
    const auto part = std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), file.size() - at)));
    VT_ASSIGN(const std::size_t got, file.read_some(at, part));
    if (got != part.size())
      return fail(ErrorCode::kIo, fmt::format("{}: the file has become shorter while it is read", file.path().string()));
    hasher.add(part);
  }
  return hasher.digest();
}

// Tiles one by one; scanlines in bands, which most formats decode from the top only.
class PictureDecoder final : public CellDecoder {
 public:
  // What decoding needs to know beside the grid.
  struct Samples {
    SampleType type = SampleType::kUint8;
    int bands = 1;
    bool tiled = false;
    int straighten_by = -1;  // the alpha band when colours are stored multiplied by it
  };

  PictureDecoder(std::shared_ptr<const FileBytes> file, const PictureFormat& format, std::unique_ptr<Input> first, const CellGrid& grid,
                 const Samples& samples)
      : file_(std::move(file)), format_(format), grid_(grid), samples_(samples) {
    give(std::move(first));
  }
  ~PictureDecoder() override { file_->pool()->readers().forget(this); }

  [[nodiscard]] const FileBytes& file() const { return *file_; }
  const CellGrid& grid() const override { return grid_; }
  std::uint64_t decoded_bytes() const { return decoded_bytes_.load(std::memory_order_relaxed); }

  Result<Block> decode_cell(std::int64_t cell_x, std::int64_t cell_y, int) const override {
    const std::int64_t top = grid_.first_row(cell_y);
    const std::int64_t rows = grid_.cell_rows(cell_y);
    VT_ASSIGN(std::unique_ptr<Input> input, borrow(top));
    Block block(static_cast<std::size_t>(rows * grid_.row_bytes()));
    std::string thrown;
    bool ok = false;
    try {
      ok = samples_.tiled ? read_tile(*input->decoder, cell_x * grid_.block_width, top, block)
                          : read_rows(*input->decoder, top, rows, block);
    } catch (const std::exception& problem) {  // OpenEXR throws through some readers
      thrown = problem.what();
    }
    std::string reason = input->decoder->geterror();
    if (reason.empty()) reason = thrown;
    if (!ok || !reason.empty()) {
      return fail(ErrorCode::kCorrupt, fmt::format("{}: row {}, column {}: {}", file_->path().string(), top, cell_x * grid_.block_width,
                                                   reason.empty() ? "cannot be decoded" : reason));
    }
    const std::int64_t from = !grid_.is_sequential ? top : input->next_row <= top ? input->next_row : 0;
    decoded_bytes_.fetch_add(static_cast<std::uint64_t>((top + rows - from) * grid_.row_bytes()), std::memory_order_relaxed);
    input->next_row = top + rows;
    give(std::move(input));
    if (samples_.straighten_by >= 0)
      straighten_alpha(samples_.type, block, samples_.bands, samples_.straighten_by, full_scale(samples_.type));
    return block;
  }

 private:
  // The idle decoder that stands closest before `row`, or any, or a new one.
  Result<std::unique_ptr<Input>> borrow(std::int64_t row) const {
    const auto closeness = [row](const IdleReader& idle) {
      const std::int64_t next_row = static_cast<const Input&>(idle).next_row;  // nobody else gives in our name
      return next_row <= row ? static_cast<double>(next_row) : -1.0;
    };
    std::unique_ptr<Input> input(static_cast<Input*>(file_->pool()->readers().take(this, closeness).release()));
    if (input) return input;
    return open_input(*file_, format_);
  }
  void give(std::unique_ptr<Input> input) const { file_->pool()->readers().give(this, std::move(input)); }

  bool read_rows(OIIO::ImageInput& decoder, std::int64_t top, std::int64_t rows, Block& out) const {
    const OIIO::ImageSpec& spec = decoder.spec();
    const int y_begin = spec.y + static_cast<int>(top);
    return decoder.read_scanlines(0, 0, y_begin, y_begin + static_cast<int>(rows), spec.z, 0, spec.nchannels, oiio_type(samples_.type),
                                  out.data());
  }

  // The inside of a tile that sticks out of the picture: rows of a whole tile's width apart.
  bool read_tile(OIIO::ImageInput& decoder, std::int64_t left, std::int64_t top, Block& out) const {
    const OIIO::ImageSpec& spec = decoder.spec();
    const int x_begin = spec.x + static_cast<int>(left);
    const int y_begin = spec.y + static_cast<int>(top);
    const int x_end = std::min(x_begin + spec.tile_width, spec.x + spec.width);
    const int y_end = std::min(y_begin + spec.tile_height, spec.y + spec.height);
    return decoder.read_tiles(0, 0, x_begin, x_end, y_begin, y_end, spec.z, spec.z + 1, 0, spec.nchannels, oiio_type(samples_.type),
                              out.data(), grid_.stride, grid_.row_bytes());
  }

  std::shared_ptr<const FileBytes> file_;
  const PictureFormat& format_;
  CellGrid grid_;
  Samples samples_;
  mutable std::atomic<std::uint64_t> decoded_bytes_ = 0;
};

class PictureSource final : public RasterSource {
 public:
  // `first_x`, `first_y`: the stored sample that is the first of the raster; stored samples outside the
  // raster are not read, and places of the raster where none is stored have no data. Only floating-point
  // samples may lack.
  PictureSource(RasterInfo info, std::int64_t first_x, std::int64_t first_y, std::unique_ptr<PictureDecoder> decoder,
                const std::shared_ptr<BlockCache>& cache, const std::shared_ptr<ScratchFile>& scratch)
      : first_x_(first_x), first_y_(first_y), decoder_(std::move(decoder)), cells_(*decoder_, cache, scratch) {
    info_ = std::move(info);
  }

  using RasterSource::read;
  Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                    store::ContentHasher* content) const override {
    VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
    if (content != nullptr) VT_CHECK(hash(window, bands, *content));
    const std::size_t bytes = sample_bytes(info_.sample_type);
    const std::size_t in_stride = bytes * static_cast<std::size_t>(info_.bands);
    const std::size_t out_stride = bytes * bands.size();
    const Window stored = stored_window(window);
    if (stored.width < window.width || stored.height < window.height) clear(window, bands, out, row_pitch_bytes);
    if (stored.width <= 0 || stored.height <= 0) return {};
    return cells_.visit(0, true, stored, [&](const std::byte* in, std::int64_t in_pitch, const Window& part) {
      for (std::int64_t row = 0; row < part.height; ++row) {
        const std::byte* from = in + row * in_pitch;
        std::byte* to = out.data() + static_cast<std::size_t>(part.y - first_y_ - window.y + row) * row_pitch_bytes +
                        static_cast<std::size_t>(part.x - first_x_ - window.x) * out_stride;
        for (std::int64_t x = 0; x < part.width; ++x, from += in_stride) {
          for (const int wanted : bands) {
            if (wanted != kLeaveAlone) std::memcpy(to, from + static_cast<std::size_t>(wanted) * bytes, bytes);
            to += bytes;
          }
        }
      }
    });
  }

  // OpenImageIO does not tell where in the file a window is stored: any change of the file is a change
  // everywhere.
  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    VT_ASSIGN(const store::ContentHash whole, cells_.cache().hash(cells_.key(0, 0, 0), [&] { return hash_file(decoder_->file()); }));
    content.add(whole.bytes);
    return {};
  }

  void release_rows_before(std::int64_t row) const override {
    cells_.release_rows_before(std::clamp<std::int64_t>(row + first_y_, 0, decoder_->grid().height));
  }
  // What OpenImageIO takes for itself is not known: some formats are unpacked whole inside.
  std::size_t resident_bytes() const override { return static_cast<std::size_t>(decoder_->grid().cell_bytes()) + cells_.resident_bytes(); }
  std::uint64_t decoded_bytes() const override { return decoder_->decoded_bytes(); }

 private:
  // The stored samples under a window of the raster.
  Window stored_window(const Window& window) const {
    const CellGrid& grid = decoder_->grid();
    const std::int64_t left = std::max<std::int64_t>(window.x + first_x_, 0);
    const std::int64_t top = std::max<std::int64_t>(window.y + first_y_, 0);
    return {.x = left,
            .y = top,
            .width = std::min(window.x + first_x_ + window.width, grid.width) - left,
            .height = std::min(window.y + first_y_ + window.height, grid.height) - top};
  }
  // No data everywhere: not a number, and no coverage.
  void clear(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes) const {
    const auto fill = [&]<class T>(T nan) {
      for (std::int64_t row = 0; row < window.height; ++row) {
        std::byte* to = out.data() + static_cast<std::size_t>(row) * row_pitch_bytes;
        for (std::int64_t x = 0; x < window.width; ++x)
          for (const int band : bands) {
            if (band != kLeaveAlone) store(to, band == info_.alpha_band ? T{0} : nan);
            to += sizeof nan;
          }
      }
    };
    info_.sample_type == SampleType::kFloat64 ? fill(std::numeric_limits<double>::quiet_NaN())
                                              : fill(std::numeric_limits<float>::quiet_NaN());
  }

  std::int64_t first_x_;
  std::int64_t first_y_;
  std::unique_ptr<PictureDecoder> decoder_;
  CellStore cells_;
};

// Tiles as they are; scanlines as one cell when the picture is small beside the cache, else in bands.
CellGrid grid_of(const OIIO::ImageSpec& spec, const RasterInfo& info, bool is_random_access, const BlockCache& cache) {
  CellGrid grid{.width = spec.width,
                .height = spec.height,
                .block_width = info.tiled ? spec.tile_width : spec.width,
                .block_height = info.tiled ? spec.tile_height : spec.height,
                .rows_per_cell = 0,
                .stride = info.bands * static_cast<std::int64_t>(sample_bytes(info.sample_type))};
  grid.rows_per_cell = grid.block_height;
  if (info.tiled || grid.cell_bytes() <= largest_cell_bytes(cache)) return grid;
  grid.rows_per_cell = std::min(rows_of_cut_cell(cache, grid.row_bytes()), grid.block_height);
  grid.is_sequential = !is_random_access;
  if (is_random_access) {
    // Bands are blocks of their own then.
    grid.rows_per_cell = (grid.rows_per_cell + kRowsCompressedTogether - 1) / kRowsCompressedTogether * kRowsCompressedTogether;
    grid.block_height = grid.rows_per_cell;
  }
  return grid;
}

// Channel names say what they are: OpenImageIO orders those of OpenEXR as red, green, blue, alpha, and names
// the bands of other formats.
std::vector<BandMeaning> meaning_of(const OIIO::ImageSpec& spec, const RasterInfo& info) {
  struct Row {
    std::string_view name;
    BandRole role;
  };
  constexpr std::array<Row, 5> kRoles{
      {{"R", BandRole::kRed}, {"G", BandRole::kGreen}, {"B", BandRole::kBlue}, {"Y", BandRole::kGrey}, {"I", BandRole::kGrey}}};
  std::vector<BandMeaning> meaning(static_cast<std::size_t>(info.bands));
  for (std::size_t b = 0; b < meaning.size(); ++b) {
    meaning[b].full_scale = full_scale(info.sample_type);
    const auto* const row = std::ranges::find(kRoles, std::string_view(spec.channelnames[b]), &Row::name);
    if (row != kRoles.end()) meaning[b].role = row->role;
    if (static_cast<int>(b) == info.alpha_band) meaning[b].role = BandRole::kCoverage;
  }
  return meaning;
}

// Where the stored samples lie in what is shown, and what is said of them otherwise.
Result<void> apply_header(const PictureHeader& header, RasterInfo& info) {
  const std::string path = info.path.string();
  if (header.orientation != 1)
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: {} is {}: only rows from the top and columns from the left (1) are read; turn the picture upright first, for "
                    "example with exiftran -ai or mogrify -auto-orient, or, where it is wrong, remove it: exiftool -Orientation= FILE",
                    path, header.orientation_source, header.orientation));
  info.place_problem = header.place_problem;
  info.unused.insert(info.unused.end(), header.unused.begin(), header.unused.end());
  if (!header.display) return {};
  const Window& display = *header.display;
  const bool may_lack = info.sample_type == SampleType::kFloat32 || info.sample_type == SampleType::kFloat64;
  const bool is_whole =
      display.x >= 0 && display.y >= 0 && display.x + display.width <= info.width && display.y + display.height <= info.height;
  if (!is_whole && !may_lack)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: the display window is larger than the data window, and whole numbers cannot lack; save "
                            "it with both windows alike",
                            path));
  if (display.x > 0 || display.y > 0 || display.x + display.width < info.width || display.y + display.height < info.height)
    info.unused.push_back({.what = "samples outside its display window"});
  if (!is_whole) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (BandMeaning& band : info.meaning)
      if (!band.nodata) band.nodata = kNan;
  }
  info.width = display.width;
  info.height = display.height;
  return {};
}

Result<std::unique_ptr<RasterSource>> read_picture(std::shared_ptr<const FileBytes> file, const PictureFormat& format,
                                                   const OpenOptions& options) {
  const std::filesystem::path path = file->path();
  VT_ASSIGN(const PictureHeader header, read_picture_header(*file, format));
  VT_ASSIGN(std::unique_ptr<Input> input, open_input(*file, format));
  const OIIO::ImageSpec& spec = input->decoder->spec();
  const auto unsupported = [&](const std::string& what) {
    return fail(ErrorCode::kUnsupported, fmt::format("{} ({}): {}", path.string(), input->decoder->format_name(), what));
  };
  VT_ASSIGN(const std::optional<PngHeader> png, read_png_header(*file));
  // OpenImageIO 2.4 forgets to swap the bytes of 16-bit samples when a PNG is interlaced: wrong values
  // without any error.
  if (png && png->bits == 16 && png->is_interlaced)
    return unsupported("a 16-bit PNG that is interlaced is not decoded reliably; save it without interlacing");
  // It also expands palettes to colours and codes of fewer than 8 bits to 8.
  if (png && options.as_numbers && (png->has_palette || png->bits < 8))
    return unsupported(
        fmt::format("its samples are {}, and this layer wants the numbers themselves, which PNG decoding does not give; "
                    "convert it, for example with gdal_translate {} numbers.tif",
                    png->has_palette ? "indices into a palette" : fmt::format("codes of {} bits", png->bits), path.filename().string()));
  if (options.as_numbers && !header.expanded_codes.empty())
    return unsupported(fmt::format(
        "its samples are {}, and this layer wants the numbers themselves, which decoding brings to 255 or 65535; convert it, for "
        "example with gdal_translate {} numbers.tif",
        header.expanded_codes, path.filename().string()));
  if (header.is_signed)
    return unsupported(fmt::format("signed samples are not decoded reliably; convert it, for example with gdal_translate {} numbers.tif",
                                   path.filename().string()));
  if (spec.deep || spec.depth > 1) return unsupported("deep and volume pictures are not read");
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) {
    return fail(ErrorCode::kInvalidData,
                fmt::format("{}: a picture of {} x {} x {}", path.string(), spec.width, spec.height, spec.nchannels));
  }
  const auto type = sample_type_of(spec);
  if (!type) return unsupported(fmt::format("samples of type {}", spec.format.c_str()));

  RasterInfo info;
  info.path = path;
  info.is_picture = true;
  info.width = spec.width;
  info.height = spec.height;
  info.bands = spec.nchannels;
  info.sample_type = *type;
  info.alpha_band = spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels ? spec.alpha_channel : -1;
  info.meaning = meaning_of(spec, info);
  info.tiled = spec.tile_width > 0 && spec.tile_height > 0;
  info.compression = spec.get_string_attribute("compression", input->decoder->format_name());
  VT_ASSIGN(const DeclaredMetadata beside, read_aux_xml(info));
  apply_declared(beside, info);
  for (BandMeaning& band : info.meaning)
    if (options.nodata) band.nodata = options.nodata;
  const std::shared_ptr<BlockCache> cache = cache_of(options);
  const CellGrid grid = grid_of(spec, info, format.has_rows_in_any_order, *cache);
  info.block_width = grid.block_width;
  info.block_height = grid.rows_per_cell;
  if (grid.row_bytes() > kMaxCellBytes / grid.rows_per_cell)
    return unsupported(
        fmt::format("{} rows of {} bytes in one piece are more than this program holds", grid.rows_per_cell, grid.row_bytes()));
  VT_CHECK(apply_header(header, info));
  VT_CHECK(apply_options(options, info));
  const bool associated = info.alpha_band >= 0 && !header.alpha_is_straight && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
  info.alpha_is_straightened = associated;
  const PictureDecoder::Samples samples{
      .type = info.sample_type, .bands = info.bands, .tiled = info.tiled, .straighten_by = associated ? info.alpha_band : -1};
  VT_ASSIGN(std::unique_ptr<TiffDecoder> mask, find_mask_beside(info, options, *cache));
  auto decoder = std::make_unique<PictureDecoder>(std::move(file), format, std::move(input), grid, samples);
  const std::int64_t first_x = header.display ? header.display->x : 0;
  const std::int64_t first_y = header.display ? header.display->y : 0;
  std::unique_ptr<RasterSource> source =
      std::make_unique<PictureSource>(std::move(info), first_x, first_y, std::move(decoder), cache, options.scratch);
  return mask ? with_mask(std::move(source), std::move(mask), cache, options.scratch) : std::move(source);
}

}  // namespace
}  // namespace vt::source

extern "C" const vt::source::PictureModule vt_picture_module = {.open_picture = vt::source::read_picture};
