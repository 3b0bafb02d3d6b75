#include "builder/encode/tile_band.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "builder/encode/block_encoder.h"
#include "store/texel/texel_decoder.h"

namespace vt::encode {
namespace {

channels::ConstPlaneRow shifted(const channels::ConstPlaneRow& row, std::int64_t texels) {
  channels::ConstPlaneRow result = row;
  for (const float*& plane : result)
    if (plane != nullptr) plane += texels;
  return result;
}

}  // namespace

bool is_one_value(std::span<const std::byte> texels, std::size_t texel_bytes) {
  // Each texel equals the one before it.
  return std::memcmp(texels.data(), texels.data() + texel_bytes, texels.size() - texel_bytes) == 0;
}

TileBand::TileBand(const LayerInfo& layer, const channels::ChannelCodec& codec, std::size_t part, store::Compression compression,
                   Quality quality, Level level, const TexelRect& core, const ReferenceRows* reference)
    : format_(layer.format),
      codec_(codec),
      part_(part),
      compression_(compression),
      quality_(quality),
      level_(level),
      core_(core),
      reference_(reference),
      tile_texels_(layer.tile_texels()),
      tile_exponent_(layer.tile_exponent),
      texel_bytes_(format_info(codec.parts()[part].texel_format).block_bytes),
      tile_row_(core.y >> layer.tile_exponent),
      next_y_(core.y),
      errors_(codec.measures().size()) {
  if (core.empty()) return;
  const std::int64_t first = core.x >> tile_exponent_;
  const std::int64_t last = (core.right() - 1) >> tile_exponent_;
  for (std::int64_t column = first; column <= last; ++column) {
    OpenTile tile;
    tile.column = static_cast<std::uint32_t>(column);
    tile.texels.resize(static_cast<std::size_t>(tile_texels_ * tile_texels_) * texel_bytes_);
    open_.push_back(std::move(tile));
  }
}

// Cuts the row at tile borders; `write_segment(offset in the row, count, out)` returns whether the segment
// has data.
template <class WriteSegment>
void TileBand::add_segments(std::int64_t y, const WriteSegment& write_segment) {
  assert(y == next_y_ && y < core_.bottom());
  ++next_y_;
  const std::int64_t row_in_tile = y & (tile_texels_ - 1);
  for (OpenTile& tile : open_) {
    const std::int64_t tile_x = std::int64_t{tile.column} << tile_exponent_;
    const std::int64_t x0 = std::max(tile_x, core_.x);
    const std::int64_t x1 = std::min(tile_x + tile_texels_, core_.right());
    std::byte* out = tile.texels.data() + static_cast<std::size_t>(row_in_tile * tile_texels_ + (x0 - tile_x)) * texel_bytes_;
    if (write_segment(x0 - core_.x, x1 - x0, out)) tile.has_data = true;
  }
}

Result<void> TileBand::add_row(std::int64_t y, const channels::RowNeighbourhood& rows) {
  Result<void> status;
  add_segments(y, [&](std::int64_t offset, std::int64_t count, std::byte* out) {
    const channels::RowNeighbourhood segment{shifted(rows.above, offset), shifted(rows.here, offset), shifted(rows.below, offset),
                                             rows.opaque};
    if (status) status = codec_.encode_row(part_, segment, count, out);
    return rows.opaque || codec_.has_data(part_, segment.here, count);
  });
  return status;
}

void TileBand::add_texels(std::int64_t y, const std::byte* texels, const channels::ConstPlaneRow& planes, bool opaque) {
  add_segments(y, [&](std::int64_t offset, std::int64_t count, std::byte* out) {
    std::memcpy(out, texels + static_cast<std::size_t>(offset) * texel_bytes_, static_cast<std::size_t>(count) * texel_bytes_);
    return opaque || codec_.has_data(part_, shifted(planes, offset), count);
  });
}

Result<void> TileBand::take_finished(const TileSink& sink) {
  const bool row_is_full = next_y_ == core_.bottom() || (next_y_ & (tile_texels_ - 1)) == 0;
  if (open_.empty() || !row_is_full || next_y_ == core_.y || tile_row_ != (next_y_ - 1) >> tile_exponent_) return {};
  for (OpenTile& tile : open_) {
    if (tile.has_data) fill_outside(tile);
    VT_ASSIGN(const EncodedTile encoded, encode(tile));
    VT_CHECK(sink(encoded));
    tile.has_data = false;
  }
  ++tile_row_;
  return {};
}

void TileBand::fill_outside(OpenTile& tile) const {
  const TexelRect rect = rect_of({level_, tile.column, static_cast<std::uint32_t>(tile_row_)}, tile_exponent_);
  const TexelRect data = intersect(rect, core_);
  if (data == rect) return;
  const auto texel = [&](std::int64_t x, std::int64_t y) {
    return tile.texels.data() + static_cast<std::size_t>((y - rect.y) * tile_texels_ + (x - rect.x)) * texel_bytes_;
  };
  const auto repeat = [&](std::int64_t from_x, std::int64_t to_x, std::int64_t count, std::int64_t y) {
    for (std::int64_t i = 0; i < count; ++i) std::memcpy(texel(to_x + i, y), texel(from_x, y), texel_bytes_);
    codec_.mark_outside(part_, texel(to_x, y), count);
  };
  for (std::int64_t y = data.y; y < data.bottom(); ++y) {
    if (data.x > rect.x) repeat(data.x, rect.x, data.x - rect.x, y);
    if (data.right() < rect.right()) repeat(data.right() - 1, data.right(), rect.right() - data.right(), y);
  }
  for (std::int64_t y = rect.y; y < rect.bottom(); ++y) {
    if (y >= data.y && y < data.bottom()) continue;
    const std::int64_t nearest = y < data.y ? data.y : data.bottom() - 1;
    std::memcpy(texel(rect.x, y), texel(rect.x, nearest), static_cast<std::size_t>(tile_texels_) * texel_bytes_);
    codec_.mark_outside(part_, texel(rect.x, y), tile_texels_);
  }
}

Result<EncodedTile> TileBand::encode(OpenTile& tile) {
  EncodedTile encoded;
  encoded.tile = {level_, tile.column, static_cast<std::uint32_t>(tile_row_)};
  encoded.is_empty = !tile.has_data;
  if (encoded.is_empty) return encoded;

  const bool is_constant = is_one_value(tile.texels, texel_bytes_);
  std::span<const std::byte> bytes = tile.texels;
  if (format_ != codec_.parts()[part_].texel_format) {
    const auto edge = static_cast<std::size_t>(is_constant ? 4 : tile_texels_);
    blocks_.resize(payload_bytes(format_info(format_), edge, edge));
    encode_blocks(format_, tile.texels, edge, edge, static_cast<std::size_t>(tile_texels_) * texel_bytes_, quality_, blocks_);
    bytes = blocks_;
  }
  measure(tile, bytes, is_constant);
  if (is_constant) {
    encoded.constant_block = bytes.first(format_info(format_).block_bytes);
  } else {
    const store::TileShape shape = store::tile_shape(format_, static_cast<std::size_t>(tile_texels_));
    VT_ASSIGN(encoded.payload, store::encode_payload(bytes, shape, compression_, compressed_));
  }
  return encoded;
}

// `stored`: the tile's texels or blocks, or one of them at least when all are the same.
void TileBand::measure(const OpenTile& tile, std::span<const std::byte> stored, bool is_constant) {
  if (reference_ == nullptr || errors_.empty()) return;
  const FormatInfo& info = format_info(format_);
  const TexelRect rect = rect_of({level_, tile.column, static_cast<std::uint32_t>(tile_row_)}, tile_exponent_);
  const TexelRect data = intersect(rect, core_);
  const auto edge = static_cast<std::size_t>(tile_texels_);
  const std::size_t row_bytes = payload_bytes(info, edge, info.block_edge);  // of a row of blocks or texels
  const std::size_t rows_at_once = 4 / info.block_edge;
  const std::size_t row_floats = edge * info.channels;
  decoded_.resize(4 * row_floats);
  for (std::int64_t group = data.y & ~std::int64_t{3}; group < data.bottom(); group += 4) {
    if (!reference_->is_measured(group)) continue;
    if (is_constant) {
      const std::size_t block = info.block_edge;
      store::decode_texels(format_, stored.first(info.block_bytes), block, block, std::span(decoded_).first(block * block * info.channels));
      for (std::size_t i = info.channels; i < decoded_.size(); ++i) decoded_[i] = decoded_[i % info.channels];
    } else {
      const std::size_t first = static_cast<std::size_t>(group - rect.y) / info.block_edge;
      store::decode_texels(format_, stored.subspan(first * row_bytes, rows_at_once * row_bytes), edge, 4, decoded_);
    }
    for (std::int64_t y = std::max(group, data.y); y < std::min(group + 4, data.bottom()); ++y) {
      codec_.add_errors(
          part_, shifted(reference_->row(y), data.x - core_.x),
          decoded_.data() + static_cast<std::size_t>(y - group) * row_floats + static_cast<std::size_t>(data.x - rect.x) * info.channels,
          data.width, errors_);
    }
  }
}

}  // namespace vt::encode
