#include "builder/channels/color/color_rows.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"

namespace vt::channels {
namespace {

class ColorRows : public test::OnEveryCpuTarget {};

TEST_P(ColorRows, AreTheCodeTableCodeByCode) {
  std::mt19937 random(3);
  for (const Transfer transfer : {Transfer::kSrgb, Transfer::kLinear}) {
    const CodeTable& table = code_table(transfer);
    for (const std::size_t count : {1U, 7U, 16U, 17U, 1000U}) {
      std::vector<std::uint8_t> rgb(3 * count);
      for (std::uint8_t& code : rgb) code = static_cast<std::uint8_t>(random());
      std::vector<float> light(3 * count);
      light_from_rgb8(rgb.data(), count, table, light.data(), light.data() + count, light.data() + 2 * count);
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(light[c * count + i], table.light(rgb[3 * i + c]));

      // Not only light of codes: everything between and beyond, and what is no number.
      std::uniform_real_distribution<float> uniform(-0.1F, 1.1F);
      for (float& v : light) v = uniform(random);
      // And what lies half way between two codes, which depends on the column.
      for (std::size_t i = 0; i < light.size(); i += 5)
        light[i] = 0.5F * (table.light(static_cast<std::uint8_t>(i % 255)) + table.light(static_cast<std::uint8_t>(i % 255 + 1)));
      light[0] = std::numeric_limits<float>::quiet_NaN();
      light.back() = std::numeric_limits<float>::infinity();
      std::vector<std::uint8_t> codes(3 * count + 1, 99);
      rgb8_from_light(light.data(), light.data() + count, light.data() + 2 * count, count, table, codes.data());
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_EQ(codes[3 * i + c], table.code(light[c * count + i], static_cast<std::int64_t>(i))) << light[c * count + i];
      EXPECT_EQ(codes.back(), 99) << "wrote past the end";
    }
  }
}

VT_ON_EVERY_CPU_TARGET(ColorRows);

}  // namespace
}  // namespace vt::channels
