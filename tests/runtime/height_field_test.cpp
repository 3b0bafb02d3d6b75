#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "runtime/virtual_texture.h"
#include "tests/runtime/test_store.h"

namespace vt::runtime {
namespace {

TEST(HeightField, ARampStaysARampAtEveryLevelAndAHoleStaysOutOfIt) {
  test::TempFolder folder;
  const Area area{.west = 100, .south = 200, .east = 500, .north = 500};
  const TexelRect data{16, 32, 400, 300};
  const int finest = 3;
  // Height = 2 east + 3 north in CRS units, from texel centers; a block in the middle was never measured.
  const auto paint = [&](Level level, std::int64_t x, std::int64_t y, std::byte* out) {
    const double size = std::ldexp(1.0, finest - level.value);
    const double column = (static_cast<double>(x) + 0.5) * size - 16;
    const double row = (static_cast<double>(y) + 0.5) * size - 32;
    float height = static_cast<float>(2 * (area.west + column) + 3 * (area.north - row));
    if (column > 180 && column < 220 && row > 130 && row < 170) height = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(out, &height, 4);
  };
  const auto reader = test::make_store(folder / "h.vts",
                                       {{.name = "dem",
                                         .channel = ChannelType::kElevation,
                                         .format = TexelFormat::kR32Float,
                                         .tile_exponent = 6,
                                         .finest = finest,
                                         .data = data,
                                         .paint = paint,
                                         .skip = {}}},
                                       area);
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  for (const int most : {400, 200, 100}) {
    const auto field = HeightField::read(**reader, (*reader)->layers()[0].id, most);
    ASSERT_TRUE(field.has_value()) << field.error().message;
    for (double u = 0.05; u < 0.99; u += 0.0937)
      for (double v = 0.05; v < 0.99; v += 0.0831) {
        if (std::abs(u - 0.5) < 0.08 && std::abs(v - 0.5) < 0.1) continue;
        // Bilinear of a ramp is exact; float heights near 2500 are good to 2^-13.
        EXPECT_NEAR(field->at({u, v}), 2 * (100 + 400 * u) + 3 * (200 + 300 * v), 0.001) << most << " texels at " << u << " " << v;
      }
    EXPECT_EQ(field->at({0.5, 0.5}, -77.0), -77.0);
    EXPECT_TRUE(std::isfinite(field->min_height()));
    EXPECT_LT(field->max_height(), 2 * 500 + 3 * 500 + 1);
  }
}

// Every level holds heights of the finest level as they are: a coarse texel's is that of the north-western
// finest texel under it.
TEST(HeightField, ARampOfPickedHeightsStaysTheSameRamp) {
  test::TempFolder folder;
  const Area area{.west = 0, .south = 0, .east = 256, .north = 256};
  const int finest = 2;
  const auto paint = [&](Level level, std::int64_t x, std::int64_t y, std::byte* out) {
    const double size = std::ldexp(1.0, finest - level.value);
    const double east = static_cast<double>(x) * size + 0.5;
    const double south = static_cast<double>(y) * size + 0.5;
    const auto height = static_cast<float>(2 * east - 3 * south);
    std::memcpy(out, &height, 4);
  };
  const auto reader = test::make_store(folder / "h.vts",
                                       {{.name = "dem",
                                         .channel = ChannelType::kElevation,
                                         .format = TexelFormat::kR32Float,
                                         .tile_exponent = 6,
                                         .finest = finest,
                                         .data = {},
                                         .paint = paint,
                                         .skip = {},
                                         .is_point_sampled = true}},
                                       area);
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  for (const int most : {256, 128, 64}) {
    const auto field = HeightField::read(**reader, (*reader)->layers()[0].id, most);
    ASSERT_TRUE(field.has_value()) << field.error().message;
    // Inside the outermost values; bilinear of a ramp is exact, and so are the heights.
    for (double east = 1.0; east < 250.0; east += 13.7)
      for (double south = 1.0; south < 250.0; south += 17.3)
        EXPECT_NEAR(field->at({east / 256.0, 1.0 - south / 256.0}), 2 * east - 3 * south, 0.001)
            << most << " texels at " << east << " " << south;
  }
}

// Codes are heights by the layer's range; code 0 is none where the layer says so.
TEST(HeightField, ReadsCodes) {
  test::TempFolder folder;
  const auto paint = [](Level, std::int64_t x, std::int64_t y, std::byte* out) {
    const auto code = static_cast<std::uint16_t>(x == 3 && y == 5 ? 0 : 100 * x + y + 1);
    std::memcpy(out, &code, 2);
  };
  const auto reader = test::make_store(folder / "r16.vts", {{.name = "dem",
                                                             .channel = ChannelType::kElevation,
                                                             .format = TexelFormat::kR16,
                                                             .tile_exponent = 4,
                                                             .finest = 0,
                                                             .data = {},
                                                             .paint = paint,
                                                             .skip = {},
                                                             .range = {.scale = 0.5, .offset = -20.0},
                                                             .zero_is_nodata = true}});
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const auto field = HeightField::read(**reader, (*reader)->layers()[0].id, 64);
  ASSERT_TRUE(field.has_value()) << field.error().message;
  for (std::int64_t y = 0; y < 16; ++y)
    for (std::int64_t x = 0; x < 16; ++x) {
      const double at = field->at({(static_cast<double>(x) + 0.5) / 16.0, 1.0 - (static_cast<double>(y) + 0.5) / 16.0}, -1e6);
      const double wanted = x == 3 && y == 5 ? -1e6 : -20.0 + 0.5 * static_cast<double>(100 * x + y + 1);
      EXPECT_NEAR(at, wanted, 1e-6) << x << "," << y;
    }
  EXPECT_EQ(field->min_height(), -19.5);
}

TEST(HeightField, RefusesColour) {
  test::TempFolder folder;
  const auto reader = test::make_store(folder / "c.vts", {{.tile_exponent = 4, .finest = 1, .data = {}, .paint = {}, .skip = {}}});
  ASSERT_TRUE(reader.has_value());
  const auto field = HeightField::read(**reader, (*reader)->layers()[0].id, 100);
  ASSERT_FALSE(field.has_value());
  EXPECT_NE(field.error().message.find("r32f"), std::string::npos);
}

}  // namespace
}  // namespace vt::runtime
