#include "builder/source/tiff/strip_stream.h"

#include <tiff.h>

#include <algorithm>
#include <array>

#include "builder/source/source_common.h"
#include "builder/source/tiff/strip_unpackers.h"
#include "builder/source/tiff/tiff_handle.h"

namespace vt::source {
namespace {

// TIFF 6.0 section 14: differences to the sample on the left, modulo the sample's range.
template <class T>
void add_up(std::span<std::byte> row, std::size_t samples) {
  for (std::size_t at = samples * sizeof(T); at + sizeof(T) <= row.size(); at += sizeof(T))
    store(row.data() + at, static_cast<T>(load<T>(row.data() + at) + load<T>(row.data() + at - samples * sizeof(T))));
}

void undo_horizontal(std::span<std::byte> row, int bits, std::size_t samples) {
  switch (bits) {
    case 8:
      return add_up<std::uint8_t>(row, samples);
    case 16:
      return add_up<std::uint16_t>(row, samples);
    case 32:
      return add_up<std::uint32_t>(row, samples);
    default:
      return add_up<std::uint64_t>(row, samples);
  }
}

// TIFF Technical Note 3: byte differences over the row's most significant bytes, then the next ones, and so
// on.
void undo_floating_point(std::span<std::byte> row, int bits, std::size_t samples, std::vector<std::byte>& planes) {
  add_up<std::uint8_t>(row, samples);
  planes.assign(row.begin(), row.end());
  const auto bytes = static_cast<std::size_t>(bits / 8);
  const std::size_t count = row.size() / bytes;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t byte = 0; byte < bytes; ++byte) row[i * bytes + byte] = planes[(bytes - 1 - byte) * count + i];
  }
}

}  // namespace

bool StripStream::can_unpack(const TiffLayout& layout) {
  constexpr std::array<std::uint16_t, 4> kCompressions = {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE,
                                                          COMPRESSION_ZSTD};
  if (layout.tiled || layout.fill_order_reversed || std::ranges::find(kCompressions, layout.compression) == kCompressions.end())
    return false;
  switch (layout.predictor) {
    case PREDICTOR_NONE:
      return true;
    case PREDICTOR_HORIZONTAL:
      return layout.bits == 8 || layout.bits == 16 || layout.bits == 32 || layout.bits == 64;
    case PREDICTOR_FLOATINGPOINT:
      return layout.sample_type == SampleType::kFloat32 || layout.sample_type == SampleType::kFloat64;
    default:
      return false;
  }
}

StripStream::StripStream(const TiffLayout& layout, const Strip& strip, std::unique_ptr<Unpacker> unpacker)
    : strip_(strip),
      bits_(layout.bits),
      predictor_(layout.predictor),
      samples_(layout.planar_separate ? 1 : layout.samples_per_pixel),
      is_swapped_(layout.byte_swapped),
      unpacker_(std::move(unpacker)),
      next_row_(strip.first_row) {}

Result<std::unique_ptr<StripStream>> StripStream::open(std::shared_ptr<const FileBytes> file, const TiffLayout& layout,
                                                       const Strip& strip) {
  StripBytes bytes(file, strip.offset, strip.bytes);
  std::unique_ptr<Unpacker> unpacker;
  if (layout.compression == COMPRESSION_LZW) {
    std::array<std::byte, 2> head{};
    VT_ASSIGN(const std::size_t got, file->read_some(strip.offset, head));
    if (got == head.size() && head[0] == std::byte{0} && (head[1] & std::byte{1}) != std::byte{0})
      return fail(ErrorCode::kUnsupported, "LZW with the least significant bit first");
    unpacker = make_lzw_unpacker(std::move(bytes));
  } else if (layout.compression == COMPRESSION_ZSTD) {
    VT_ASSIGN(unpacker, make_zstd_unpacker(std::move(bytes)));
  } else {
    VT_ASSIGN(unpacker, make_deflate_unpacker(std::move(bytes)));
  }
  return std::unique_ptr<StripStream>(new StripStream(layout, strip, std::move(unpacker)));
}

Result<void> StripStream::read_rows(std::span<std::byte> out, std::size_t row_bytes) {
  VT_CHECK(unpacker_->unpack(out));
  // The floating-point predictor works on bytes and leaves the native order behind.
  if (is_swapped_ && predictor_ != PREDICTOR_FLOATINGPOINT) swap_samples(bits_, out);
  for (std::size_t at = 0; at < out.size(); at += row_bytes) {
    const std::span<std::byte> row = out.subspan(at, row_bytes);
    if (predictor_ == PREDICTOR_HORIZONTAL) undo_horizontal(row, bits_, static_cast<std::size_t>(samples_));
    if (predictor_ == PREDICTOR_FLOATINGPOINT) undo_floating_point(row, bits_, static_cast<std::size_t>(samples_), planes_);
  }
  next_row_ += static_cast<std::int64_t>(out.size() / row_bytes);
  return {};
}

Result<std::unique_ptr<StripStream>> StripStreamPool::borrow(const TiffLayout& layout, const StripStream::Strip& strip, std::int64_t row) {
  const auto is_usable = [&](const StripStream& stream) { return stream.strip() == strip && stream.next_row() <= row; };
  const auto closeness = [&](const IdleReader& idle) {
    const auto& stream = static_cast<const StripStream&>(idle);  // nobody else gives in our name
    return is_usable(stream) ? static_cast<double>(stream.next_row()) : -1.0;
  };
  std::unique_ptr<StripStream> stream(static_cast<StripStream*>(file_->pool()->readers().take(this, closeness).release()));
  if (stream && is_usable(*stream)) return stream;
  return StripStream::open(file_, layout, strip);
}

}  // namespace vt::source
