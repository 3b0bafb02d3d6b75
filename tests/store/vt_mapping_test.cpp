#include "store/vt_mapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "store/channel.h"
#include "store/texel_format.h"

namespace vt {
namespace {

struct Case {
  Area area;
  LayerInfo layer;
};

// Areas and grids as datasets have them: degrees and metres, vt exponents up to the limit, data anywhere in
// the padded square.
Case random_case(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Case c;
  const bool degrees = random() % 2 == 0;
  const double size = degrees ? 0.01 + 359.0 * unit(random) : 100.0 + 1e6 * unit(random);
  c.area = {.west = degrees ? -180.0 + 300.0 * unit(random) : 5e5 * unit(random),
            .south = degrees ? -90.0 * unit(random) : 6e6 * unit(random)};
  c.area.east = c.area.west + size;
  c.area.north = c.area.south + size * (0.1 + unit(random));
  c.layer.tile_exponent = static_cast<std::uint8_t>(2 + random() % 8);
  c.layer.finest = {static_cast<std::uint8_t>(random() % 23)};
  const std::int64_t side = std::int64_t{1} << c.layer.vt_exponent();
  c.layer.data.x = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(side));
  c.layer.data.y = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(side));
  c.layer.data.width = side - c.layer.data.x;
  c.layer.data.height = side - c.layer.data.y;
  c.layer.grid.step_x = size / static_cast<double>(c.layer.data.width);
  c.layer.grid.step_y = size / static_cast<double>(c.layer.data.height);
  c.layer.grid.origin_x = c.area.west + size * 0.1 * unit(random);
  c.layer.grid.origin_y = c.area.north - size * 0.1 * unit(random);
  return c;
}

TEST(VtMapping, AgreesWithLongDoubleToAThousandthOfATexelOrTheRoundingOfItsInput) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Case c = random_case(random);
    const VtMapping mapping(c.area, c.layer);
    const Point2 uv{unit(random), unit(random)};
    const Level level{static_cast<std::uint8_t>(random() % (c.layer.finest.value + 1U))};
    const Point2 texel = mapping.texel_from_uv(level, uv);

    using Long = long double;
    const Long scale = std::ldexp(Long{1}, level.value - c.layer.finest.value);
    const Long x = Long{c.area.west} * (1 - Long{uv.x}) + Long{c.area.east} * Long{uv.x};
    const Long y = Long{c.area.south} * (1 - Long{uv.y}) + Long{c.area.north} * Long{uv.y};
    const Long texel_x = ((x - Long{c.layer.grid.origin_x}) / Long{c.layer.grid.step_x} + static_cast<Long>(c.layer.data.x)) * scale;
    const Long texel_y = ((Long{c.layer.grid.origin_y} - y) / Long{c.layer.grid.step_y} + static_cast<Long>(c.layer.data.y)) * scale;
    // Four roundings of the coordinate (each half a unit in its last place), counted in texels, and four of
    // the texel position itself.
    const double epsilon = 0x1p-53;
    const double size_x = std::max(std::abs(c.area.west), std::abs(c.area.east)) + std::abs(c.layer.grid.origin_x);
    const double size_y = std::max(std::abs(c.area.south), std::abs(c.area.north)) + std::abs(c.layer.grid.origin_y);
    const double side = std::ldexp(1.0, level.value + c.layer.tile_exponent);
    EXPECT_NEAR(texel.x, static_cast<double>(texel_x), 4 * epsilon * (size_x / c.layer.grid.step_x * static_cast<double>(scale) + side));
    EXPECT_NEAR(texel.y, static_cast<double>(texel_y), 4 * epsilon * (size_y / c.layer.grid.step_y * static_cast<double>(scale) + side));
  }
}

TEST(VtMapping, EveryWayBackIsTheWayThere) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const Case c = random_case(random);
    const VtMapping mapping(c.area, c.layer);
    const Point2 uv{unit(random), unit(random)};
    // In units of the area: the coordinates' own size against the area's is what rounding is amplified by.
    const double tolerance_x = 16 * 0x1p-53 * (1.0 + 2.0 * (std::abs(c.area.west) + std::abs(c.area.east)) / (c.area.east - c.area.west));
    const double tolerance_y =
        16 * 0x1p-53 * (1.0 + 2.0 * (std::abs(c.area.south) + std::abs(c.area.north)) / (c.area.north - c.area.south));
    for (const int level : {0, c.layer.finest.value / 2, int{c.layer.finest.value}}) {
      const Level l{static_cast<std::uint8_t>(level)};
      const Point2 back = mapping.uv_from_texel(l, mapping.texel_from_uv(l, uv));
      // The offset of the data inside the square adds its own rounding.
      const double side = std::ldexp(1.0, c.layer.vt_exponent());
      EXPECT_NEAR(back.x, uv.x, tolerance_x + 8 * 0x1p-53 * side / static_cast<double>(c.layer.data.width));
      EXPECT_NEAR(back.y, uv.y, tolerance_y + 8 * 0x1p-53 * side * c.layer.grid.step_y / (c.area.north - c.area.south));
    }
    const Point2 same = mapping.uv_from_crs(mapping.crs_from_uv(uv));
    EXPECT_NEAR(same.x, uv.x, tolerance_x);
    EXPECT_NEAR(same.y, uv.y, tolerance_y);
  }
}

TEST(VtMapping, TheAreasCornersAreExact) {
  const Case c = {.area = {.west = -179.3, .south = -12.1, .east = 0.7, .north = 77.7}, .layer = {}};
  const VtMapping mapping(c.area, c.layer);
  EXPECT_EQ(mapping.crs_from_uv({0, 0}).x, c.area.west);
  EXPECT_EQ(mapping.crs_from_uv({0, 0}).y, c.area.south);
  EXPECT_EQ(mapping.crs_from_uv({1, 1}).x, c.area.east);
  EXPECT_EQ(mapping.crs_from_uv({1, 1}).y, c.area.north);
}

TEST(VtMapping, SouthWestIsTheOriginOfTexturesAndNorthWestThatOfTexels) {
  Case c;
  c.layer.tile_exponent = 4;
  c.layer.finest = {2};
  c.layer.data = {0, 0, 64, 64};
  c.layer.grid = {.origin_x = 0.0, .origin_y = 1.0, .step_x = 1.0 / 64, .step_y = 1.0 / 64};
  const VtMapping mapping(c.area, c.layer);
  EXPECT_EQ(mapping.texel_from_uv({2}, {0, 1}).x, 0.0);
  EXPECT_EQ(mapping.texel_from_uv({2}, {0, 1}).y, 0.0);
  EXPECT_EQ(mapping.texel_from_uv({2}, {1, 0}).x, 64.0);
  EXPECT_EQ(mapping.texel_from_uv({2}, {1, 0}).y, 64.0);
  EXPECT_EQ(mapping.texel_from_uv({0}, {0.5, 0.25}).x, 8.0);
  EXPECT_EQ(mapping.texel_from_uv({0}, {0.5, 0.25}).y, 12.0);
  EXPECT_EQ(mapping.crs_from_texel({0}, {8, 12}).y, 0.25);
}

TEST(VtMapping, TheAffineFormIsTheSameMap) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const Case c = random_case(random);
    const VtMapping mapping(c.area, c.layer);
    const Point2 uv{unit(random), unit(random)};
    const VtMapping::Affine affine = mapping.st_from_uv();
    const Point2 texel = mapping.texel_from_uv(c.layer.finest, uv);
    const double side = std::ldexp(1.0, c.layer.vt_exponent());
    const auto rounding = [&](double size, double step) { return 8 * 0x1p-53 * (size / step / side + 2.0); };
    EXPECT_NEAR(affine.scale_x * uv.x + affine.offset_x, texel.x / side,
                rounding(std::abs(c.area.west) + std::abs(c.area.east), c.layer.grid.step_x));
    EXPECT_NEAR(affine.scale_y * uv.y + affine.offset_y, 1.0 - texel.y / side,
                rounding(std::abs(c.area.south) + std::abs(c.area.north), c.layer.grid.step_y));
  }
}

TEST(Level, PaperNumberingIsItsOwnInverse) {
  for (int finest = 0; finest <= 23; ++finest) {
    const Level f{static_cast<std::uint8_t>(finest)};
    EXPECT_EQ(paper_level(f, f), 0);
    EXPECT_EQ(paper_level(Level{0}, f), finest);
    for (int level = 0; level <= finest; ++level) {
      const Level l{static_cast<std::uint8_t>(level)};
      EXPECT_EQ(level_from_paper(paper_level(l, f), f), l);
    }
  }
}

TEST(TexelRect, CoarserRoundsOutwardAlsoForNegativeCoordinates) {
  EXPECT_EQ(coarser({-3, 5, 4, 1}, 1), (TexelRect{-2, 2, 3, 1}));
  EXPECT_EQ(coarser({0, 0, 1, 1}, 20), (TexelRect{0, 0, 1, 1}));
  EXPECT_EQ(coarser({7, 8, 9, 8}, 3), (TexelRect{0, 1, 2, 1}));
}

TEST(TexelFormat, EveryFormatIsFoundByNumberAndByName) {
  const int last = static_cast<int>(kTexelFormats.size());
  for (int number = 0; number < 70000; number += number < 300 ? 1 : 997) {
    const auto format = format_from_number(static_cast<std::uint16_t>(number));
    EXPECT_EQ(format.has_value(), number % 65536 >= 1 && number % 65536 <= last) << number;
    if (format) {
      EXPECT_EQ(static_cast<int>(*format), number);
      EXPECT_EQ(format_info(*format).format, *format);
      EXPECT_EQ(format_from_name(format_info(*format).name), format);
    }
  }
  EXPECT_EQ(format_from_name("rgb9"), std::nullopt);
  EXPECT_EQ(payload_bytes(format_info(TexelFormat::kBc1), 256, 256), 32768U);
  EXPECT_EQ(payload_bytes(format_info(TexelFormat::kRgb8), 256, 256), 196608U);
  EXPECT_EQ(payload_bytes(format_info(TexelFormat::kRgba32Float), 4096, 4096), std::size_t{256} << 20);
}

TEST(Channel, NumbersAreRegisteredPrivateOrOfNewerPrograms) {
  for (const unsigned number : {0U, 1U, 8U, 9U, 4711U, 0x7FFFU, 0x8000U, 0xFFFFU}) {
    const auto type = static_cast<ChannelType>(number);
    EXPECT_EQ(is_registered(type), number >= 1 && number <= 8) << number;
    EXPECT_EQ(is_private(type), number >= 0x8000U) << number;
  }
}

TEST(TexelFormat, ANumberThatIsNotKnownHasANameAndTilesOfNoSize) {
  for (const std::size_t number : {std::size_t{0}, kTexelFormats.size() + 1, std::size_t{999}, std::size_t{0xFFFF}}) {
    const auto format = static_cast<TexelFormat>(number);
    EXPECT_FALSE(is_known(format));
    EXPECT_EQ(format_name(format), "format " + std::to_string(number));
    EXPECT_EQ(format_info(format).samples, SampleKind::kOpaque);
    EXPECT_EQ(payload_bytes(format_info(format), 256, 256), 0U);
  }
}

}  // namespace
}  // namespace vt
