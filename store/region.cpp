#include "store/region.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "store/format/tile_text.h"
#include "store/io/bytes.h"
#include "store/texel/block_enlarger.h"
#include "store/texel/half.h"

namespace vt::store {
namespace {

// What fills a texel (or block) that no level has: zero bytes, or "no data" in every channel of a float
// format.
constexpr std::size_t kMostBlockBytes = 16;
static_assert(std::ranges::all_of(kTexelFormats, [](const FormatInfo& info) { return info.block_bytes <= kMostBlockBytes; }));

std::array<std::byte, kMostBlockBytes> missing_block(TexelFormat format) {
  std::array<std::byte, kMostBlockBytes> block = {};
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

// Replicates one row of an ancestor's texels. `bytes` is a constant for the usual sizes, so that each copy is
// one move.
void enlarge_row(auto bytes, const std::byte* coarse_row, std::int64_t coarse_first, std::int64_t x, std::int64_t width, int steps,
                 std::byte* out) {
  for (std::int64_t i = 0; i < width; ++i)
    std::memcpy(out + static_cast<std::size_t>(i) * bytes, coarse_row + static_cast<std::size_t>(((x + i) >> steps) - coarse_first) * bytes,
                bytes);
}
template <std::size_t kBytes>
using Bytes = std::integral_constant<std::size_t, kBytes>;

// Fills `rect` (in blocks of the wanted level) from `source`, a tile `steps` levels coarser that covers it.
void enlarge(const Canvas& canvas, const BlockRect& rect, const FormatInfo& format, std::span<const std::byte> source, TileId source_tile,
             std::int64_t tile_blocks, int steps) {
  const std::int64_t first_x = std::int64_t{source_tile.x} * tile_blocks;
  const std::int64_t first_y = std::int64_t{source_tile.y} * tile_blocks;
  const std::size_t bytes = format.block_bytes;
  const std::size_t source_pitch = static_cast<std::size_t>(tile_blocks) * bytes;
  for (std::int64_t y = rect.y; y < rect.y + rect.height; ++y) {
    const std::byte* row = source.data() + static_cast<std::size_t>((y >> steps) - first_y) * source_pitch;
    std::byte* out = canvas.at(rect.x, y);
    if (is_block_format(format)) {
      for (std::int64_t x = rect.x; x < rect.x + rect.width; ++x, out += bytes)
        enlarge_block(format.format, {row + static_cast<std::size_t>((x >> steps) - first_x) * bytes, bytes}, x, y, steps, {out, bytes});
      continue;
    }
    const auto enlarge_in = [&](auto texel_bytes) { enlarge_row(texel_bytes, row, first_x, rect.x, rect.width, steps, out); };
    switch (bytes) {
      case 1:
        enlarge_in(Bytes<1>());
        break;
      case 2:
        enlarge_in(Bytes<2>());
        break;
      case 3:
        enlarge_in(Bytes<3>());
        break;
      case 4:
        enlarge_in(Bytes<4>());
        break;
      case 8:
        enlarge_in(Bytes<8>());
        break;
      case 16:
        enlarge_in(Bytes<16>());
        break;
      default:
        enlarge_in(bytes);
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
