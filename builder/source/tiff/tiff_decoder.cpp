#include "builder/source/tiff/tiff_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "builder/source/source_common.h"
#include "builder/source/tiff/compression_bounds.h"

namespace vt::source {
namespace {

constexpr std::int64_t kMostlyWantedBytes = std::int64_t{4} << 20;  // of one read that takes along what lies between wanted samples
// Blocks larger than this are left to the system's own reading ahead.
constexpr std::uint64_t kMostExpectedBytes = std::uint64_t{2} << 20;
// Compressed strips up to this size are left to libtiff, which holds them whole.
constexpr std::uint64_t kLargestHeldStrip = std::uint64_t{4} << 20;
constexpr std::int64_t kHashedAtOnce = std::int64_t{1} << 20;

static_assert(std::endian::native == std::endian::little, "24-bit samples and libtiff's RGBA words are taken apart as little-endian");

// Most significant bit first, rows start at whole bytes, whatever the file's byte order; writers of 24-bit
// samples keep to that too.
template <class T>
void unpack_row(const std::byte* row, int bits, std::int64_t count, std::byte* out) {
  std::uint64_t window = 0;
  int held = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    for (; held < bits; held += 8) window = window << 8 | std::to_integer<std::uint64_t>(*row++);
    held -= bits;
    store(out + i * static_cast<std::int64_t>(sizeof(T)), static_cast<T>(window >> held & ((std::uint64_t{1} << bits) - 1)));
  }
}

// A small IEEE-like format to binary32: exact, every such number fits.
float widen_float(std::uint32_t code, int exponent_bits, int mantissa_bits) {
  const std::uint32_t mantissa = code & ((1U << mantissa_bits) - 1);
  const std::uint32_t exponent = code >> mantissa_bits & ((1U << exponent_bits) - 1);
  const bool negative = (code >> (mantissa_bits + exponent_bits) & 1) != 0;
  const int bias = (1 << (exponent_bits - 1)) - 1;
  if (exponent == (1U << exponent_bits) - 1) {  // infinities and NaN keep their payload bits
    return std::bit_cast<float>((negative ? 0x80000000U : 0U) | 0x7F800000U | mantissa << (23 - mantissa_bits));
  }
  const float magnitude =
      exponent == 0 ? std::ldexp(static_cast<float>(mantissa), 1 - bias - mantissa_bits)
                    : std::ldexp(static_cast<float>(mantissa | 1U << mantissa_bits), static_cast<int>(exponent) - bias - mantissa_bits);
  return negative ? -magnitude : magnitude;
}

// All bands of interleaved samples but `kept`, which may be -1.
template <class T>
void invert_codes(std::span<std::byte> bytes, double max_code, std::size_t bands, int kept) {
  const T max = static_cast<T>(max_code);
  for (std::size_t i = 0; (i + 1) * sizeof(T) <= bytes.size(); ++i) {
    if (static_cast<int>(i % bands) == kept) continue;
    std::byte* const place = bytes.data() + i * sizeof(T);
    store(place, static_cast<T>(max - load<T>(place)));
  }
}

}  // namespace

TiffDecoder::TiffDecoder(std::shared_ptr<const FileBytes> file, std::uint16_t directory, TiffLayout layout,
                         const store::ContentHash& fingerprint)
    : file_(file),
      name_(file->path().string()),
      layout_(std::move(layout)),
      fingerprint_(fingerprint),
      handles_(file, directory),
      streams_(std::move(file)) {}

Result<std::unique_ptr<TiffDecoder>> TiffDecoder::create(std::unique_ptr<TiffHandle> handle, std::shared_ptr<const FileBytes> file,
                                                         std::uint16_t directory, TiffLayout layout, const store::ContentHash& fingerprint,
                                                         const BlockCache& cache) {
  std::unique_ptr<TiffDecoder> decoder(new TiffDecoder(std::move(file), directory, std::move(layout), fingerprint));
  TiffDecoder& d = *decoder;
  const TiffLayout& l = d.layout_;
  const bool rgba = l.recipe == SampleRecipe::kLibtiffRgba;
  const std::int64_t stored_samples = l.planar_separate ? 1 : l.samples_per_pixel;
  d.stored_row_bytes_ = rgba ? l.block_width * 4 : (l.block_width * stored_samples * l.bits + 7) / 8;
  d.rows_are_seekable_ = l.compression == COMPRESSION_NONE && !l.fill_order_reversed && !rgba;
  d.direct_ = d.rows_are_seekable_ && l.recipe == SampleRecipe::kNative && l.palette.empty() && !l.invert && !l.alpha_is_associated;

  d.can_stream_ = StripStream::can_unpack(l);

  CellGrid& grid = d.grid_;
  grid = {.width = l.width,
          .height = l.height,
          .block_width = l.block_width,
          .block_height = l.block_height,
          .rows_per_cell = l.block_height,
          .stride = static_cast<std::int64_t>(sample_bytes(l.sample_type)) * l.bands_per_plane(),
          .planes = l.planar_separate ? l.bands : 1};
  const std::int64_t row_bytes = std::max(d.stored_row_bytes_, grid.row_bytes());
  const bool can_be_cut = d.rows_are_seekable_ || (!l.tiled && !rgba);
  if (can_be_cut && row_bytes > largest_cell_bytes(cache) / l.block_height) {
    grid.rows_per_cell = std::min(rows_of_cut_cell(cache, row_bytes), l.block_height);
    grid.is_sequential = !d.rows_are_seekable_;
  }
  if (!d.direct_ && row_bytes > kMaxCellBytes / grid.rows_per_cell) {
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: {} of {} x {} samples in one piece are {} MB unpacked, more than {} MB; rewrite the file with smaller tiles",
                    d.name_, l.tiled ? "tiles" : "strips", l.block_width, l.block_height,
                    (static_cast<double>(row_bytes) * static_cast<double>(grid.rows_per_cell)) / (1 << 20), kMaxCellBytes >> 20));
  }
  if (!rgba) {
    // libtiff must agree on the size of a row, or its writes would not fit our buffers.
    const std::uint64_t libtiff_row = l.tiled ? TIFFTileRowSize64(handle->get()) : TIFFScanlineSize64(handle->get());
    if (libtiff_row != static_cast<std::uint64_t>(d.stored_row_bytes_)) {
      return fail(ErrorCode::kUnsupported, fmt::format("{}: rows of {} bytes by the tags, {} by the decoder (subsampled data?)", d.name_,
                                                       d.stored_row_bytes_, libtiff_row));
    }
  }
  d.handles_.give(std::move(handle));
  return decoder;
}

std::uint32_t TiffDecoder::block_index(std::int64_t block_x, std::int64_t block_y, int plane) const {
  return static_cast<std::uint32_t>((plane * layout_.blocks_down + block_y) * layout_.blocks_across + block_x);
}

tl::unexpected<Error> TiffDecoder::damaged(std::int64_t block_x, std::int64_t row, const std::string& what) const {
  return fail(ErrorCode::kCorrupt, fmt::format("{}: row {}, column {}: {}", name_, row, block_x * layout_.block_width, what));
}

Result<TiffDecoder::BlockPlace> TiffDecoder::block_place(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, int plane) const {
  const std::uint32_t index = block_index(block_x, block_y, plane);
  int offset_missing = 0;
  int bytes_missing = 0;
  handle.clear_messages();
  BlockPlace place;
  place.offset = TIFFGetStrileOffsetWithErr(handle.get(), index, &offset_missing);
  place.bytes = TIFFGetStrileByteCountWithErr(handle.get(), index, &bytes_missing);
  const std::int64_t row = block_y * layout_.block_height;
  if (handle.io_error()) return tl::unexpected(*handle.io_error());
  if (offset_missing != 0 || bytes_missing != 0) {
    return damaged(block_x, row, fmt::format("the file's tables do not tell where block {} is ({})", index, handle.error()));
  }
  if (place.bytes == 0 && handle.saw_short_tables()) {
    return damaged(block_x, row, fmt::format("the file's table of block sizes ends before block {}", index));
  }
  if (place.is_sparse()) return place;
  if (place.offset == 0 || place.offset > file_->size() || place.bytes > file_->size() - place.offset) {
    return damaged(block_x, row,
                   fmt::format("block {} should be {} bytes at {}, but the file has {} bytes; it is damaged or incomplete", index,
                               place.bytes, place.offset, file_->size()));
  }
  return place;
}

Result<void> TiffDecoder::check_claim(const BlockPlace& place, std::int64_t block_x, std::int64_t block_y) const {
  if (place.is_sparse() || rows_are_seekable_) return {};  // rows that are read from their place are looked for there
  const std::int64_t rows = layout_.rows_in_block(block_y);
  // What libtiff turns into four bytes a place may be stored as three inks or as little as a byte and a half.
  const std::int64_t row_bytes = layout_.recipe == SampleRecipe::kLibtiffRgba ? layout_.block_width : stored_row_bytes_;
  const std::uint64_t least = least_stored_bytes(layout_.compression, row_bytes, rows);
  if (place.bytes >= least) return {};
  return damaged(block_x, block_y * layout_.block_height,
                 fmt::format("{} rows of {} bytes are claimed to be in {} bytes, but as {} they take at least {}; the file is damaged or "
                             "incomplete",
                             rows, row_bytes, place.bytes, compression_name(layout_.compression), least));
}

void TiffDecoder::expect_below(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, int plane) const {
  if (block_y + 1 >= layout_.blocks_down) return;
  // If its place is damaged, reading it will tell.
  const auto place = block_place(handle, block_x, block_y + 1, plane);
  if (place && !place->is_sparse() && place->bytes <= kMostExpectedBytes) file_->expect(place->offset, place->bytes);
}

Result<void> TiffDecoder::read_uncompressed(const BlockPlace& place, std::int64_t block_x, std::int64_t row, std::int64_t offset_in_block,
                                            std::span<std::byte> out) const {
  const auto offset = static_cast<std::uint64_t>(offset_in_block);
  if (offset > place.bytes || out.size() > place.bytes - offset) {
    return damaged(block_x, row,
                   fmt::format("the block holds {} bytes, {} are needed; it is damaged or incomplete", place.bytes, offset + out.size()));
  }
  VT_ASSIGN(const std::size_t got, file_->read_some(place.offset + offset, out));
  if (got != out.size()) {
    return damaged(block_x, row, fmt::format("the file ends {} bytes early; it is incomplete", out.size() - got));
  }
  if (layout_.byte_swapped && layout_.recipe != SampleRecipe::kPackedBits) swap_samples(layout_.bits, out);
  return {};
}

Result<void> TiffDecoder::read_direct(const BlockRect& rect, std::span<std::byte> out) const {
  BlockPlace place;
  {
    VT_ASSIGN(auto handle, handles_.borrow());
    VT_ASSIGN(place, block_place(*handle, rect.block_x, rect.block_y, rect.plane));
    if (rect.row == 0) expect_below(*handle, rect.block_x, rect.block_y, rect.plane);
  }
  if (place.is_sparse()) {
    fill_sparse(out);
    return {};
  }
  const std::int64_t raster_row = rect.block_y * layout_.block_height + rect.row;
  const std::int64_t offset = rect.row * stored_row_bytes_ + rect.column * grid_.stride;
  if (rect.columns == layout_.block_width) return read_uncompressed(place, rect.block_x, raster_row, offset, out);

  const auto wanted_bytes = static_cast<std::size_t>(rect.columns * grid_.stride);
  const bool mostly_wanted = rect.columns * 2 >= layout_.block_width && stored_row_bytes_ * rect.rows <= kMostlyWantedBytes;
  if (!mostly_wanted) {
    for (std::int64_t row = 0; row < rect.rows; ++row) {
      VT_CHECK(read_uncompressed(place, rect.block_x, raster_row + row, offset + row * stored_row_bytes_,
                                 out.subspan(static_cast<std::size_t>(row) * wanted_bytes, wanted_bytes)));
    }
    return {};
  }
  // One large read is cheaper than one for each row: from the first wanted sample to the last.
  Block rows(static_cast<std::size_t>((rect.rows - 1) * stored_row_bytes_) + wanted_bytes);
  VT_CHECK(read_uncompressed(place, rect.block_x, raster_row, offset, rows));
  for (std::int64_t row = 0; row < rect.rows; ++row) {
    std::memcpy(out.data() + static_cast<std::size_t>(row) * wanted_bytes, rows.data() + row * stored_row_bytes_, wanted_bytes);
  }
  return {};
}

void TiffDecoder::fill_sparse(std::span<std::byte> out) const {
  const double value = layout_.fill.value_or(0.0);
  const auto fill_with = [&]<class T>(T code) {
    for (std::size_t i = 0; i + sizeof(T) <= out.size(); i += sizeof(T)) store(out.data() + i, code);
  };
  const auto fill_integer = [&]<class T>(T) {
    const bool fits =
        value >= static_cast<double>(std::numeric_limits<T>::min()) && value <= static_cast<double>(std::numeric_limits<T>::max());
    fill_with(fits ? static_cast<T>(value) : T{0});
  };
  if (layout_.recipe != SampleRecipe::kNative || value == 0.0) {
    std::ranges::fill(out, std::byte{0});  // codes that need unpacking: zero, whatever their width
    return;
  }
  // The palette's indices are stored in `bits`, whatever our samples are after the expansion.
  if (!layout_.palette.empty()) {
    layout_.bits == 16 ? fill_integer(std::uint16_t{}) : fill_integer(std::uint8_t{});
    return;
  }
  visit_sample_type(layout_.sample_type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_floating_point_v<T>) {
      fill_with(static_cast<T>(value));
    } else {
      fill_integer(T{});
    }
  });
}

Result<void> TiffDecoder::decode_whole(TiffHandle& handle, std::uint32_t index, Block& out) const {
  const auto size = static_cast<tmsize_t>(out.size());
  const tmsize_t got = layout_.tiled ? TIFFReadEncodedTile(handle.get(), index, out.data(), size)
                                     : TIFFReadEncodedStrip(handle.get(), index, out.data(), size);
  handle.next_scanline = -1;
  if (got == size && !handle.saw_damage()) return {};
  return fail(ErrorCode::kCorrupt, handle.error().empty() ? fmt::format("the decoder gave {} of {} bytes", got, size) : handle.error());
}

// libtiff decodes a strip from its start only, so a handle that stands before the wanted row goes on from
// there.
Result<void> TiffDecoder::decode_scanlines(TiffHandle& handle, std::int64_t first, std::int64_t rows, int plane, Block& out) const {
  const std::int64_t strip_start = first / layout_.block_height * layout_.block_height;
  const bool goes_on = handle.scanline_plane == plane && handle.next_scanline >= strip_start && handle.next_scanline <= first;
  const std::int64_t started_at = goes_on ? handle.next_scanline : strip_start;
  std::int64_t row = started_at;
  handle.next_scanline = -1;
  Block skipped;
  for (; row < first + rows; ++row) {
    std::byte* target = nullptr;
    if (row < first) {
      skipped.resize(static_cast<std::size_t>(stored_row_bytes_));
      target = skipped.data();
    } else {
      target = out.data() + (row - first) * stored_row_bytes_;
    }
    if (TIFFReadScanline(handle.get(), target, static_cast<std::uint32_t>(row), static_cast<std::uint16_t>(plane)) != 1 ||
        handle.saw_damage()) {
      return fail(ErrorCode::kCorrupt, fmt::format("row {}: {}", row, handle.error()));
    }
  }
  decoded_bytes_.fetch_add(static_cast<std::uint64_t>((row - started_at) * stored_row_bytes_), std::memory_order_relaxed);
  handle.next_scanline = row;
  handle.scanline_plane = plane;
  return {};
}

Result<void> TiffDecoder::decode_rgba(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, Block& out) const {
  const auto width = static_cast<std::size_t>(layout_.block_width);
  const auto block_rows = static_cast<std::size_t>(layout_.tiled ? layout_.block_height : layout_.rows_in_block(block_y));
  const auto rows = static_cast<std::size_t>(layout_.rows_in_block(block_y));
  std::vector<std::uint32_t> words(width * static_cast<std::size_t>(layout_.block_height));
  const auto x = static_cast<std::uint32_t>(block_x * layout_.block_width);
  const auto y = static_cast<std::uint32_t>(block_y * layout_.block_height);
  const int ok =
      layout_.tiled ? TIFFReadRGBATileExt(handle.get(), x, y, words.data(), 1) : TIFFReadRGBAStripExt(handle.get(), y, words.data(), 1);
  handle.next_scanline = -1;
  if (ok != 1 || handle.saw_damage()) return fail(ErrorCode::kCorrupt, handle.error());
  for (std::size_t row = 0; row < rows; ++row) {
    std::memcpy(out.data() + row * width * 4, words.data() + (block_rows - 1 - row) * width,
                width * 4);  // libtiff counts rows from the bottom
  }
  return {};
}

Result<void> TiffDecoder::decode_stream(const StripStream::Strip& strip, std::int64_t first, std::int64_t rows, Block& out) const {
  VT_ASSIGN(auto stream, streams_.borrow(layout_, strip, first));
  const auto row_bytes = static_cast<std::size_t>(stored_row_bytes_);
  const std::int64_t started_at = stream->next_row();
  Block skipped(first > started_at ? row_bytes : 0);
  while (stream->next_row() < first) VT_CHECK(stream->read_rows(skipped, row_bytes));
  VT_CHECK(stream->read_rows(out, row_bytes));
  decoded_bytes_.fetch_add(static_cast<std::uint64_t>((first + rows - started_at) * stored_row_bytes_), std::memory_order_relaxed);
  streams_.give(std::move(stream));
  return {};
}

// Decoders bring 24-bit samples into native order; unpacking wants them as they are in the file.
Block TiffDecoder::as_in_file(Block stored) const {
  if (layout_.recipe == SampleRecipe::kPackedBits && layout_.bits == 24 && layout_.byte_swapped) swap_samples(24, stored);
  return stored;
}

Result<Block> TiffDecoder::stored_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const {
  const std::int64_t block_y = cell_y / grid_.cells_per_block();
  const std::int64_t first = grid_.first_row(cell_y);
  const std::int64_t rows = grid_.cell_rows(cell_y);
  const bool by_scanline = grid_.is_sequential && grid_.cells_per_block() > 1;
  VT_ASSIGN(auto handle, handles_.borrow(by_scanline ? first : -1, plane));
  VT_ASSIGN(const BlockPlace place, block_place(*handle, cell_x, block_y, plane));
  VT_CHECK(check_claim(place, cell_x, block_y));
  // Rows of a tile that stick out of the raster are not asked for: some writers leave them out.
  Block stored(static_cast<std::size_t>(rows * stored_row_bytes_));
  if (place.is_sparse()) {
    fill_sparse(stored);
    return stored;
  }
  expect_below(*handle, cell_x, block_y, plane);
  if (rows_are_seekable_) {
    VT_CHECK(read_uncompressed(place, cell_x, first, (first - block_y * layout_.block_height) * stored_row_bytes_, stored));
    return stored;
  }
  if (by_scanline && can_stream_ && place.bytes > kLargestHeldStrip) {
    const std::int64_t strip_top = block_y * layout_.block_height;
    const auto streamed =
        decode_stream({.offset = place.offset, .bytes = place.bytes, .first_row = strip_top, .plane = plane}, first, rows, stored);
    if (streamed) return as_in_file(std::move(stored));
    if (streamed.error().code == ErrorCode::kCorrupt) return damaged(cell_x, first, streamed.error().message);
    if (streamed.error().code != ErrorCode::kUnsupported) return tl::unexpected(streamed.error());
  }
  handle->clear_messages();
  Result<void> decoded = layout_.recipe == SampleRecipe::kLibtiffRgba ? decode_rgba(*handle, cell_x, block_y, stored)
                         : by_scanline                                ? decode_scanlines(*handle, first, rows, plane, stored)
                                                                      : decode_whole(*handle, block_index(cell_x, block_y, plane), stored);
  if (!by_scanline) decoded_bytes_.fetch_add(stored.size(), std::memory_order_relaxed);
  if (!decoded && handle->io_error()) return tl::unexpected(*handle->io_error());
  if (!decoded) return damaged(cell_x, first, decoded.error().message);
  return as_in_file(std::move(stored));
}

Block TiffDecoder::converted(Block stored, std::int64_t rows, int plane) const {
  const int stored_bands = layout_.planar_separate ? 1 : layout_.samples_per_pixel;
  const std::int64_t samples_across = layout_.block_width * stored_bands;
  const SampleType stored_type =
      layout_.palette.empty() ? layout_.sample_type : (layout_.bits <= 8 ? SampleType::kUint8 : SampleType::kUint16);
  const auto stored_bytes = static_cast<std::int64_t>(sample_bytes(stored_type));

  Block samples;
  if (layout_.recipe == SampleRecipe::kNative) {
    samples = std::move(stored);
    samples.resize(static_cast<std::size_t>(rows * samples_across * stored_bytes));
  } else if (layout_.recipe == SampleRecipe::kLibtiffRgba) {
    const std::size_t count = static_cast<std::size_t>(rows * layout_.block_width);
    samples.resize(count * 3);
    for (std::size_t i = 0; i < count; ++i) std::memcpy(samples.data() + 3 * i, stored.data() + 4 * i, 3);
  } else {
    samples.resize(static_cast<std::size_t>(rows * samples_across * stored_bytes));
    for (std::int64_t row = 0; row < rows; ++row) {
      const std::byte* in = stored.data() + row * stored_row_bytes_;
      std::byte* out = samples.data() + row * samples_across * stored_bytes;
      if (layout_.recipe == SampleRecipe::kHalfFloat || layout_.recipe == SampleRecipe::kFloat24) {
        const bool half = layout_.recipe == SampleRecipe::kHalfFloat;
        for (std::int64_t i = 0; i < samples_across; ++i) {
          std::uint32_t code = 0;
          std::memcpy(&code, in + i * (half ? 2 : 3), half ? 2 : 3);
          store(out + 4 * i, half ? widen_float(code, 5, 10) : widen_float(code, 7, 16));
        }
      } else {
        switch (stored_bytes) {
          case 1:
            unpack_row<std::uint8_t>(in, layout_.bits, samples_across, out);
            break;
          case 2:
            unpack_row<std::uint16_t>(in, layout_.bits, samples_across, out);
            break;
          default:
            unpack_row<std::uint32_t>(in, layout_.bits, samples_across, out);
            break;
        }
      }
    }
  }

  // In separate planes, coverage is a plane of its own.
  const int kept = !layout_.planar_separate ? layout_.alpha_band : layout_.alpha_band == plane ? 0 : -1;
  if (layout_.invert) {
    const auto bands = static_cast<std::size_t>(stored_bands);
    visit_sample_type(layout_.sample_type, [&]<class T>(std::type_identity<T>) {
      if constexpr (std::is_unsigned_v<T>) invert_codes<T>(samples, layout_.max_code, bands, kept);
    });
  }
  if (!layout_.palette.empty()) samples = colors_of(samples, static_cast<std::size_t>(rows * layout_.block_width));
  if (layout_.alpha_is_associated) {
    straighten_alpha(layout_.sample_type, samples, layout_.bands, layout_.alpha_band, layout_.max_code);
  }
  return samples;
}

Block TiffDecoder::colors_of(const Block& indices, std::size_t count) const {
  const bool is_wide = layout_.bits > 8;
  const auto code = [&](std::size_t i) {
    return is_wide ? load<std::uint16_t>(indices.data() + 2 * i) : std::to_integer<std::uint32_t>(indices[i]);
  };
  const auto bands = static_cast<std::size_t>(layout_.bands);
  const bool has_alpha_band = layout_.samples_per_pixel == 2;
  const std::size_t step = has_alpha_band ? 2 : 1;
  Block colors(count * bands);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t color = layout_.palette[code(step * i)];  // as many entries as there are codes of `bits`
    if (has_alpha_band && color >> 24U != 0) {
      const std::uint32_t full = (std::uint32_t{1} << layout_.bits) - 1;
      const std::uint32_t alpha = is_wide ? (code(step * i + 1) * 255 + full / 2) / full : code(step * i + 1);
      color = (color & 0xFFFFFFU) | alpha << 24U;
    }
    std::memcpy(colors.data() + i * bands, &color, bands);
  }
  return colors;
}

Result<Block> TiffDecoder::decode_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const {
  VT_ASSIGN(Block stored, stored_cell(cell_x, cell_y, plane));
  return converted(std::move(stored), grid_.cell_rows(cell_y), plane);
}

Result<store::ContentHash> TiffDecoder::hash_piece(std::int64_t cell_x, std::int64_t cell_y, int plane) const {
  const std::int64_t block_y = cell_y / grid_.cells_per_block();
  BlockPlace place;
  {
    VT_ASSIGN(auto handle, handles_.borrow());
    VT_ASSIGN(place, block_place(*handle, cell_x, block_y, plane));
  }
  if (place.is_sparse()) return store::ContentHash{};
  if (rows_are_seekable_) {
    const auto offset = static_cast<std::uint64_t>((grid_.first_row(cell_y) - block_y * layout_.block_height) * stored_row_bytes_);
    const auto wanted = static_cast<std::uint64_t>(grid_.cell_rows(cell_y) * stored_row_bytes_);
    // A block that is too short cannot be read, but it can be told from others.
    place.offset += std::min(offset, place.bytes);
    place.bytes = std::min(wanted, place.bytes - std::min(offset, place.bytes));
  }
  store::ContentHasher hasher;
  Block buffer(static_cast<std::size_t>(std::min<std::uint64_t>(place.bytes, kHashedAtOnce)));
  for (std::uint64_t done = 0; done < place.bytes;) {
    const auto part = std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), place.bytes - done)));
    VT_ASSIGN(const std::size_t got, file_->read_some(place.offset + done, part));
    if (got != part.size()) return damaged(cell_x, grid_.first_row(cell_y), "the file ends early; it is incomplete");
    hasher.add(part);
    done += part.size();
  }
  return hasher.digest();
}

std::size_t TiffDecoder::resident_bytes() const {
  if (direct_) return static_cast<std::size_t>(std::min(kMostlyWantedBytes, stored_row_bytes_ * grid_.block_height));
  const std::int64_t cell = stored_row_bytes_ * grid_.rows_per_cell + grid_.cell_bytes();
  if (rows_are_seekable_) return static_cast<std::size_t>(std::max(cell, kHashedAtOnce));
  // libtiff holds the compressed bytes of a block whole. They may be a little more than the samples, never
  // more than the file.
  const auto unpacked = static_cast<std::uint64_t>(stored_row_bytes_) * static_cast<std::uint64_t>(grid_.block_height);
  std::uint64_t compressed = std::min(file_->size(), unpacked + unpacked / 8);
  if (grid_.is_sequential && can_stream_) compressed = std::min(compressed, kLargestHeldStrip);
  return static_cast<std::size_t>(cell) + static_cast<std::size_t>(std::max<std::uint64_t>(compressed, kHashedAtOnce));
}

}  // namespace vt::source
