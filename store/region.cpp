#include "store/region.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "store/format/tile_text.h"
#include "store/io/bytes.h"
#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "store/texel/half.h"
#include "store/texel/solid_block.h"

namespace vt::store {
namespace {

// What fills a texel (or block) that no level has: zero bytes, or "no data" in every channel of a float format.
std::array<std::byte, 16> missing_block(TexelFormat format) {
  std::array<std::byte, 16> block = {};
  switch (format_info(format).samples) {
    case SampleKind::kUnorm8:
    case SampleKind::kUnorm16:
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      break;
    case SampleKind::kHalf:
      for (std::size_t at = 0; at < block.size(); at += 2) put<std::uint16_t>(block, at, kHalfNoData);
      break;
    case SampleKind::kFloat:
      for (std::size_t at = 0; at < block.size(); at += 4) put<std::uint32_t>(block, at, 0x7FC00000);
      break;
  }
  return block;
}

// The last tile read of one kind, since neighbouring holes share their ancestor.
class TileBuffer {
 public:
  [[nodiscard]] Result<std::span<const std::byte>> read(const StoreReader& reader, const LayerInfo& layer, TileId tile) {
    if (tile_ != tile) {
      bytes_.resize(layer.tile_payload_bytes());
      tile_.reset();
      VT_CHECK(reader.read(layer.id, tile, bytes_));
      tile_ = tile;
    }
    return std::span<const std::byte>(bytes_);
  }

 private:
  std::optional<TileId> tile_;
  std::vector<std::byte> bytes_;
};

// The output as rows of blocks (a block is one texel in plain formats), placed on the level's own block grid.
struct BlockRect {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

struct Canvas {
  std::span<std::byte> bytes;
  std::size_t pitch = 0;
  std::size_t block_bytes = 0;
  std::int64_t x = 0;  // of the first block
  std::int64_t y = 0;

  [[nodiscard]] std::byte* at(std::int64_t block_x, std::int64_t block_y) const {
    return bytes.data() + static_cast<std::size_t>(block_y - y) * pitch + static_cast<std::size_t>(block_x - x) * block_bytes;
  }
  void fill(const BlockRect& rect, std::span<const std::byte> block) const {
    for (std::int64_t row = rect.y; row < rect.y + rect.height; ++row)
      fill_constant(block.first(block_bytes), {at(rect.x, row), static_cast<std::size_t>(rect.width) * block_bytes});
  }
};

// Half a block, or a whole one, of a format that keeps two end points and then an index a texel: what BC1, BC3, BC4 and BC5 are made of.
struct IndexedBlock {
  int index_bits = 0;  // the 16 of them are the upper bits of 8 bytes
};
constexpr IndexedBlock kColorBlock{2};
constexpr IndexedBlock kChannelBlock{3};

// The blocks that make up one of the format's; none where indices alone do not tell.
std::span<const IndexedBlock> indexed_blocks(TexelFormat format) {
  static constexpr std::array kBc1 = {kColorBlock};
  static constexpr std::array kBc3 = {kChannelBlock, kColorBlock};
  static constexpr std::array kBc4 = {kChannelBlock};
  static constexpr std::array kBc5 = {kChannelBlock, kChannelBlock};
  if (format == TexelFormat::kBc1) return kBc1;
  if (format == TexelFormat::kBc3) return kBc3;
  if (format == TexelFormat::kBc4) return kBc4;
  if (format == TexelFormat::kBc5) return kBc5;
  return {};
}

// Such a block of a level `steps` coarser than the wanted one, enlarged 2^steps times, as seen by fine block (x, y): its end points in
// their order (so the mode that it chooses stays), and the index of the coarse texel under each of the 16 fine texels.
void enlarge_block(IndexedBlock block, const std::byte* coarse, std::int64_t x, std::int64_t y, int steps, std::byte* fine) {
  const auto coarse_bits = get<std::uint64_t>({coarse, 8}, 0);
  const int end_point_bits = 64 - 16 * block.index_bits;
  const std::uint64_t index_mask = (std::uint64_t{1} << block.index_bits) - 1;
  std::uint64_t fine_bits = coarse_bits & ((std::uint64_t{1} << end_point_bits) - 1);
  for (int texel = 0; texel < 16; ++texel) {
    const std::int64_t coarse_x = ((x * 4 + texel % 4) >> steps) & 3;
    const std::int64_t coarse_y = ((y * 4 + texel / 4) >> steps) & 3;
    const std::uint64_t index = coarse_bits >> (end_point_bits + block.index_bits * (coarse_y * 4 + coarse_x)) & index_mask;
    fine_bits |= index << (end_point_bits + block.index_bits * texel);
  }
  put<std::uint64_t>({fine, 8}, 0, fine_bits);
}

// The blocks of BC7 and BC6H tell too little by their indices: several subsets, whose shapes cannot be enlarged. From 4 times on a fine
// block lies inside one coarse texel and is that texel, exactly. Enlarged twice it covers 2 x 2 texels, and is their mean.
template <class Texels, class Mean>
auto texel_under(const Texels& coarse, std::int64_t x, std::int64_t y, int steps, const Mean& mean) {
  const auto at = [&](std::int64_t column, std::int64_t row) { return coarse[static_cast<std::size_t>(row * 4 + column)]; };
  const std::int64_t first_x = ((x * 4) >> steps) & 3;
  const std::int64_t first_y = ((y * 4) >> steps) & 3;
  auto texel = at(first_x, first_y);
  if (steps > 1) return texel;
  for (std::size_t c = 0; c < texel.size(); ++c)
    texel[c] = mean(at(first_x, first_y)[c], at(first_x + 1, first_y)[c], at(first_x, first_y + 1)[c], at(first_x + 1, first_y + 1)[c]);
  return texel;
}
std::array<std::byte, 16> enlarge_bptc(TexelFormat format, std::span<const std::byte, 16> coarse, std::int64_t x, std::int64_t y,
                                       int steps) {
  if (format == TexelFormat::kBc7) {
    const auto mean = [](unsigned a, unsigned b, unsigned c, unsigned d) { return static_cast<std::uint8_t>((a + b + c + d + 2) / 4); };
    return solid_bc7_block(texel_under(decode_bc7_block(coarse), x, y, steps, mean));
  }
  const auto mean = [](std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
    return half_from_float((float_from_half(a) + float_from_half(b) + float_from_half(c) + float_from_half(d)) / 4.0F);
  };
  return solid_bc6h_block(texel_under(decode_bc6h_block(coarse), x, y, steps, mean));
}

// Replicates one row of an ancestor's texels. `Bytes` is a constant so that each copy is one move.
template <std::size_t Bytes>
void enlarge_row(const std::byte* coarse_row, std::int64_t coarse_first, std::int64_t x, std::int64_t width, int steps, std::byte* out) {
  for (std::int64_t i = 0; i < width; ++i)
    std::memcpy(out + static_cast<std::size_t>(i) * Bytes, coarse_row + static_cast<std::size_t>(((x + i) >> steps) - coarse_first) * Bytes,
                Bytes);
}

// Fills `rect` (in blocks of the wanted level) from `source`, a tile `steps` levels coarser that covers it.
void enlarge(const Canvas& canvas, const BlockRect& rect, const FormatInfo& format, std::span<const std::byte> source, TileId source_tile,
             std::int64_t tile_blocks, int steps) {
  const std::int64_t first_x = std::int64_t{source_tile.x} * tile_blocks;
  const std::int64_t first_y = std::int64_t{source_tile.y} * tile_blocks;
  const std::size_t source_pitch = static_cast<std::size_t>(tile_blocks) * format.block_bytes;
  for (std::int64_t y = rect.y; y < rect.y + rect.height; ++y) {
    const std::byte* row = source.data() + static_cast<std::size_t>((y >> steps) - first_y) * source_pitch;
    std::byte* out = canvas.at(rect.x, y);
    if (format.block_edge > 1) {
      for (std::int64_t x = rect.x; x < rect.x + rect.width; ++x) {
        const std::byte* coarse = row + static_cast<std::size_t>((x >> steps) - first_x) * format.block_bytes;
        if (indexed_blocks(format.format).empty()) {
          const auto block = enlarge_bptc(format.format, std::span<const std::byte, 16>(coarse, 16), x, y, steps);
          out = std::copy(block.begin(), block.end(), out);
          continue;
        }
        for (const IndexedBlock block : indexed_blocks(format.format)) {
          enlarge_block(block, coarse, x, y, steps, out);
          coarse += 8;
          out += 8;
        }
      }
      continue;
    }
    switch (format.block_bytes) {
      case 1:
        enlarge_row<1>(row, first_x, rect.x, rect.width, steps, out);
        break;
      case 2:
        enlarge_row<2>(row, first_x, rect.x, rect.width, steps, out);
        break;
      case 3:
        enlarge_row<3>(row, first_x, rect.x, rect.width, steps, out);
        break;
      case 4:
        enlarge_row<4>(row, first_x, rect.x, rect.width, steps, out);
        break;
      case 8:
        enlarge_row<8>(row, first_x, rect.x, rect.width, steps, out);
        break;
      case 16:
        enlarge_row<16>(row, first_x, rect.x, rect.width, steps, out);
        break;
      default:
        assert(false);
    }
  }
}

}  // namespace

Result<RegionReport> read_region(const StoreReader& reader, LayerId id, Level level, const TexelRect& rect, std::span<std::byte> out,
                                 std::size_t row_pitch_bytes) {
  VT_CHECK(reader.check_readable(id));
  const LayerInfo* layer = reader.find_layer(id);
  if (level.value + layer->tile_exponent > kMaxVtExponent)
    return fail(ErrorCode::kUsage, reader.path().string() + ": level " + std::to_string(level.value) + " is over 2^31 texels wide");
  if (layer->holds_blobs()) return fail(ErrorCode::kUsage, reader.path().string() + ": layer " + layer->name + " holds blobs, no texels");
  RegionReport report;
  if (rect.empty()) return report;

  // From here on everything is counted in blocks, which for plain formats are texels.
  const FormatInfo& format = format_info(layer->format);
  const std::int64_t edge = format.block_edge;
  assert(rect.x % edge == 0 && rect.y % edge == 0 && rect.width % edge == 0 && rect.height % edge == 0);
  const BlockRect wanted{rect.x / edge, rect.y / edge, rect.width / edge, rect.height / edge};
  const std::size_t row_bytes = static_cast<std::size_t>(wanted.width) * format.block_bytes;
  const Canvas canvas{.bytes = out,
                      .pitch = row_pitch_bytes != 0 ? row_pitch_bytes : row_bytes,
                      .block_bytes = format.block_bytes,
                      .x = wanted.x,
                      .y = wanted.y};
  assert(canvas.pitch >= row_bytes && out.size() >= canvas.pitch * static_cast<std::size_t>(wanted.height - 1) + row_bytes);
  const auto texels_in = [&](const BlockRect& part) { return static_cast<std::uint64_t>(part.width * part.height * edge * edge); };

  // Outside the padded square there is nothing.
  const std::int64_t tile_blocks = std::int64_t{layer->tile_texels()} / edge;
  const std::int64_t side = tile_blocks << level.value;
  const TexelRect inside = intersect({wanted.x, wanted.y, wanted.width, wanted.height}, {0, 0, side, side});
  const auto missing = missing_block(layer->format);
  const std::uint64_t texels_outside =
      texels_in(wanted) - (inside.empty() ? 0 : texels_in({inside.x, inside.y, inside.width, inside.height}));
  if (texels_outside > 0) {
    canvas.fill(wanted, missing);
    report.texels_missing += texels_outside;
  }
  if (inside.empty()) return report;

  TileBuffer own;
  TileBuffer ancestor;
  const int shift = std::countr_zero(static_cast<std::uint64_t>(tile_blocks));
  const TexelRect tiles = coarser(inside, shift);
  for (std::int64_t tile_y = tiles.y; tile_y < tiles.bottom(); ++tile_y) {
    for (std::int64_t tile_x = tiles.x; tile_x < tiles.right(); ++tile_x) {
      const TileId tile{level, static_cast<std::uint32_t>(tile_x), static_cast<std::uint32_t>(tile_y)};
      const TexelRect overlap = intersect(inside, rect_of(tile, shift));
      const BlockRect part{overlap.x, overlap.y, overlap.width, overlap.height};
      VT_ASSIGN(const std::optional<TileId> source, reader.nearest_present(id, tile));
      if (!source) {
        canvas.fill(part, missing);
        report.texels_missing += texels_in(part);
        continue;
      }
      const bool is_own = *source == tile;
      (is_own ? report.texels_own_level : report.texels_from_coarser) += texels_in(part);

      // A whole tile into a block of its own size needs no buffer between.
      if (is_own && canvas.pitch == static_cast<std::size_t>(tile_blocks) * format.block_bytes && part.width == tile_blocks &&
          part.height == tile_blocks) {
        VT_CHECK(reader.read(id, tile, {canvas.at(part.x, part.y), layer->tile_payload_bytes()}));
        continue;
      }
      VT_ASSIGN(const std::span<const std::byte> texels, (is_own ? own : ancestor).read(reader, *layer, *source));
      if (!is_own) {
        enlarge(canvas, part, format, texels, *source, tile_blocks, level.value - source->level.value);
        continue;
      }
      const std::size_t tile_pitch = static_cast<std::size_t>(tile_blocks) * format.block_bytes;
      for (std::int64_t y = part.y; y < part.y + part.height; ++y)
        std::memcpy(canvas.at(part.x, y),
                    texels.data() + static_cast<std::size_t>(y - tile_y * tile_blocks) * tile_pitch +
                        static_cast<std::size_t>(part.x - tile_x * tile_blocks) * format.block_bytes,
                    static_cast<std::size_t>(part.width) * format.block_bytes);
    }
  }
  return report;
}

}  // namespace vt::store
