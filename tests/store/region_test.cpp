#include "store/region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "store/io/bytes.h"
#include "store/texel/half.h"
#include "store/texel/texel_decoder.h"
#include "tests/store/store_support.h"
#include "tests/support/format_lists.h"

namespace vt::store {
namespace {

using namespace test;

// One texel as the layer's format holds it; for BC1 the two end points as stored and the texel's own index,
// which is all that a decoder sees of it; for other blocks what the decoder makes of it.
using Texel = std::vector<std::byte>;

Texel texel_in_block(const FormatInfo& format, const std::byte* block, std::int64_t x, std::int64_t y) {
  if (format.block_edge == 1) return Texel(block, block + format.block_bytes);
  const std::int64_t number = (y % 4) * 4 + x % 4;
  if (format.format == TexelFormat::kBc1) {
    const int bit = static_cast<int>(2 * number);
    Texel texel(block, block + 4);
    texel.push_back((block[4 + bit / 8] >> (bit % 8)) & std::byte{3});
    return texel;
  }
  std::vector<float> samples(16UL * format.channels);
  decode_texels(format.format, {block, format.block_bytes}, 4, 4, samples);
  const auto bytes =
      std::as_bytes(std::span(samples)).subspan(static_cast<std::size_t>(number) * format.channels * 4, format.channels * 4UL);
  return Texel(bytes.begin(), bytes.end());
}

// The mean of the 2 x 2 texels around (x, y) that a block of the next finer level covers: to the nearest
// code, or to the nearest half.
Texel mean_of_quadrant(const FormatInfo& format, const std::byte* block, std::int64_t x, std::int64_t y) {
  std::vector<float> samples(16UL * format.channels);
  decode_texels(format.format, {block, format.block_bytes}, 4, 4, samples);
  std::vector<float> means;
  for (std::size_t c = 0; c < format.channels; ++c) {
    double sum = 0.0;
    for (const std::int64_t row : {y % 4 / 2 * 2, y % 4 / 2 * 2 + 1})
      for (const std::int64_t column : {x % 4 / 2 * 2, x % 4 / 2 * 2 + 1})
        sum += samples[static_cast<std::size_t>(row * 4 + column) * format.channels + c];
    means.push_back(format.format == TexelFormat::kBc7 ? static_cast<float>(std::floor(sum / 4.0 + 0.5))
                                                       : float_from_half(half_from_float(static_cast<float>(sum / 4.0))));
  }
  const auto bytes = std::as_bytes(std::span(means));
  return Texel(bytes.begin(), bytes.end());
}

// Definition: the texel of the nearest present ancestor-or-self tile that covers (x, y); nothing where there
// is none.
struct Found {
  Texel texel;
  int steps = 0;
};
std::optional<Found> texel_by_definition(const LayerInfo& layer, const Contents& contents, int level, std::int64_t x, std::int64_t y) {
  if (x < 0 || y < 0) return std::nullopt;
  const std::int64_t side = std::int64_t{1} << (level + layer.tile_exponent);
  if (x >= side || y >= side) return std::nullopt;
  for (int steps = 0; steps <= level; ++steps) {
    const std::int64_t cx = x >> steps;
    const std::int64_t cy = y >> steps;
    const TileId tile{Level{static_cast<std::uint8_t>(level - steps)}, static_cast<std::uint32_t>(cx >> layer.tile_exponent),
                      static_cast<std::uint32_t>(cy >> layer.tile_exponent)};
    const auto at = contents.find({layer.name, tile});
    if (at == contents.end()) continue;
    const std::int64_t in_x = cx & (layer.tile_texels() - 1);
    const std::int64_t in_y = cy & (layer.tile_texels() - 1);
    const FormatInfo& format = format_info(layer.format);
    const std::int64_t block = (in_y / format.block_edge) * (layer.tile_texels() / format.block_edge) + in_x / format.block_edge;
    const std::byte* bytes = at->second.data() + block * format.block_bytes;
    const bool is_mean = steps == 1 && (format.format == TexelFormat::kBc6h || format.format == TexelFormat::kBc7);
    return Found{is_mean ? mean_of_quadrant(format, bytes, in_x, in_y) : texel_in_block(format, bytes, in_x, in_y), steps};
  }
  return std::nullopt;
}

Texel texel_of_region(const FormatInfo& format, std::span<const std::byte> region, std::size_t pitch, std::int64_t x, std::int64_t y) {
  const std::byte* block = region.data() + static_cast<std::size_t>(y / format.block_edge) * pitch +
                           static_cast<std::size_t>(x / format.block_edge) * format.block_bytes;
  return texel_in_block(format, block, x, y);
}

Texel missing_texel(const FormatInfo& format) {
  Texel block(format.block_bytes);
  if (format.samples == SampleKind::kFloat)
    for (std::size_t at = 0; at < block.size(); at += 4) put<std::uint32_t>(block, at, 0x7FC00000);
  if (format.samples == SampleKind::kHalf)
    for (std::size_t at = 0; at < block.size(); at += 2) put<std::uint16_t>(block, at, 0x7E00);
  return texel_in_block(format, block.data(), 0, 0);
}

class Region : public testing::TestWithParam<TexelFormat> {};

TEST_P(Region, IsTheNearestAncestorsTexelEverywhere) {
  const FormatInfo& format = format_info(GetParam());
  std::mt19937 random(17);
  for (int round = 0; round < 12; ++round) {
    const TempFolder folder;
    const int finest = 1 + static_cast<int>(random() % 5);
    const LayerInfo layer = small_layer("l", GetParam(), 2 + static_cast<int>(random() % 3), finest);
    StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}, {.sync = false}));
    const LayerId id = value_of(writer.add_layer(layer));
    Contents contents;
    for (int level = 0; level <= finest; ++level) {
      for (std::uint32_t y = 0; y < (1U << level); ++y) {
        for (std::uint32_t x = 0; x < (1U << level); ++x) {
          const TileId tile{Level{static_cast<std::uint8_t>(level)}, x, y};
          const auto dice = random() % 8;
          if (dice < 3) continue;
          Bytes bytes = tile_bytes(layer, tile);
          if (dice == 3) {
            for (std::size_t i = format.block_bytes; i < bytes.size(); ++i) bytes[i] = bytes[i - format.block_bytes];
            succeed(writer.put_constant(id, tile, std::span(bytes).first(format.block_bytes)));
          } else {
            succeed(writer.put(id, tile, encoded(bytes, {Codec::kZstd, 1})));
          }
          contents[{layer.name, tile}] = std::move(bytes);
        }
      }
    }
    succeed(writer.finish());
    const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));

    for (int trial = 0; trial < 25; ++trial) {
      const int level = static_cast<int>(random() % static_cast<unsigned>(finest + 2));  // also one deeper than the layer
      const std::int64_t side = std::int64_t{1} << (level + layer.tile_exponent);
      const auto pick = [&](std::int64_t low, std::int64_t high) {
        return (low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low))) / format.block_edge * format.block_edge;
      };
      const TexelRect rect{pick(-2 * format.block_edge - 6, side), pick(-2 * format.block_edge - 6, side), pick(4, side / 2 + 12),
                           pick(4, side / 2 + 12)};
      const std::size_t row_bytes = payload_bytes(format, static_cast<std::size_t>(rect.width), format.block_edge);
      const std::size_t pitch = row_bytes + (trial % 2) * 5;
      const std::size_t rows = static_cast<std::size_t>(rect.height) / format.block_edge;
      Bytes out(pitch * (rows - 1) + row_bytes, std::byte{0xEE});
      const auto report = read_region(reader, id, Level{static_cast<std::uint8_t>(level)}, rect, out, trial % 2 == 0 ? 0 : pitch);
      ASSERT_TRUE(report) << report.error().message;

      RegionReport truth;
      for (std::int64_t y = 0; y < rect.height; ++y) {
        for (std::int64_t x = 0; x < rect.width; ++x) {
          const auto wanted = texel_by_definition(layer, contents, level, rect.x + x, rect.y + y);
          ASSERT_EQ(texel_of_region(format, out, pitch, x, y), wanted ? wanted->texel : missing_texel(format))
              << x << "," << y << " of level " << level;
          (!wanted ? truth.texels_missing : wanted->steps == 0 ? truth.texels_own_level : truth.texels_from_coarser) += 1;
        }
      }
      EXPECT_EQ(report->texels_own_level, truth.texels_own_level);
      EXPECT_EQ(report->texels_from_coarser, truth.texels_from_coarser);
      EXPECT_EQ(report->texels_missing, truth.texels_missing);
      // What lies between the rows belongs to the caller.
      for (std::size_t row = 0; row + 1 < rows; ++row)
        for (std::size_t i = row_bytes; i < pitch; ++i) ASSERT_EQ(out[row * pitch + i], std::byte{0xEE});
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, Region, testing::ValuesIn(vt::test::formats_with_samples()),
                         [](const auto& instance) { return std::string(format_info(instance.param).name); });

TEST(ReadRegion, AWholeTileIsTheTile) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 5, 2);
  const LayerId id = value_of(writer.add_layer(layer));
  const TileId tile{Level{2}, 3, 1};
  succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile))));
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  Bytes out(layer.tile_payload_bytes());
  ASSERT_TRUE(read_region(reader, id, tile.level, rect_of(tile, layer.tile_exponent), out));
  EXPECT_EQ(out, tile_bytes(layer, tile));
}

TEST(ReadRegion, FarOutsideAndEmptyRectanglesAreOrdinary) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerId id = value_of(writer.add_layer(small_layer("l", TexelFormat::kR32Float, 5, 2)));
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  Bytes out(4 * 6);
  EXPECT_EQ(read_region(reader, id, {2}, {-1000000, 5000000, 2, 3}, out)->texels_missing, 6U);
  EXPECT_EQ(read_region(reader, id, {2}, {0, 0, 0, 3}, out)->texels_missing, 0U);
  EXPECT_EQ(read_region(reader, id, {30}, {0, 0, 2, 3}, out).error().code, ErrorCode::kUsage);
  EXPECT_EQ(read_region(reader, LayerId{5}, {0}, {0, 0, 2, 3}, out).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace vt::store
