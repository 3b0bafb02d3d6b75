#include "builder/channels/shared/neighbours.h"

#include <gtest/gtest.h>

#include <limits>

#include "builder/channels/shared/format_of_channels.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

// Plane p of the texel in row r and column x.
float number_at(int r, std::int64_t x, std::size_t p) {
  return static_cast<float>(100 * r + 10 * static_cast<int>(x) + static_cast<int>(p));
}

// Plane 4 is the weight, which is 1.
Rows numbered_rows() {
  Rows rows(5);
  for (int r = 0; r < 3; ++r)
    for (std::int64_t x = -1; x <= 5; ++x)
      for (std::size_t p = 0; p < 6; ++p) rows.row(r)[p][x] = p == 4 ? 1.0F : number_at(r, x, p);
  return rows;
}

TEST(SumAround, AddsTheNineTexelsOfEachPlaneThatIsNamed) {
  Rows rows = numbered_rows();
  for (const std::int64_t i : {0, 2, 4}) {
    const auto [five, two, weight] = sum_around<double>(rows.middle(false), std::array<std::size_t, 3>{5, 2, 4}, i);
    // Nine times the middle of what is linear.
    EXPECT_EQ(five, 9.0 * static_cast<double>(number_at(1, i, 5)));
    EXPECT_EQ(two, 9.0 * static_cast<double>(number_at(1, i, 2)));
    EXPECT_EQ(weight, 9.0);
  }
}

TEST(SumAround, LeavesOutWhatWeighsTooLittle) {
  Rows rows(3);
  rows.row(0)[0][0] = 1.0F;  // weighs nothing, as all that is not named here
  rows.row(0)[0][2] = 2.0F;
  rows.row(0)[1][2] = 0.25F;
  rows.row(2)[0][1] = 4.0F;
  rows.row(2)[1][1] = 0.5F;
  const auto sum = [&](float least) { return sum_around<float>(rows.middle(false), std::array<std::size_t, 2>{0, 1}, 1, least); };
  EXPECT_EQ(sum(0.0F), (std::array<float, 2>{7.0F, 0.75F}));
  EXPECT_EQ(sum(std::numeric_limits<float>::min()), (std::array<float, 2>{6.0F, 0.75F}));
  EXPECT_EQ(sum(0.25F), (std::array<float, 2>{6.0F, 0.75F})) << "as much as the least is enough";
  EXPECT_EQ(sum(0.5F), (std::array<float, 2>{4.0F, 0.5F}));
  EXPECT_EQ(sum(1.0F), (std::array<float, 2>{0.0F, 0.0F}));
}

TEST(SumAround, AddsFromWestToEastAndNorthToSouth) {
  // In floats 2^24 + 1 is 2^24: only the ones that come after the large number has gone count.
  Rows rows(3);
  constexpr float kLarge = 0x1p24F;
  const std::array<float, 9> in_order{kLarge, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F, -kLarge, 1.0F};
  for (std::size_t k = 0; k < in_order.size(); ++k) rows.row(static_cast<int>(k / 3))[0][k % 3] = in_order[k];
  const std::array<std::size_t, 2> planes{0, 1};
  EXPECT_EQ(sum_around<float>(rows.middle(false), planes, 1)[0], 1.0F);
  EXPECT_EQ(sum_around<double>(rows.middle(false), planes, 1)[0], 7.0);
}

TEST(FormatOfChannels, KeepsTheKindOfSamples) {
  EXPECT_EQ(format_of_channels(TexelFormat::kRgb8, 1), TexelFormat::kR8);
  EXPECT_EQ(format_of_channels(TexelFormat::kRgba8, 2), TexelFormat::kRg8);
  EXPECT_EQ(format_of_channels(TexelFormat::kR8, 3), TexelFormat::kRgb8);
  EXPECT_EQ(format_of_channels(TexelFormat::kR8, 4), TexelFormat::kRgba8);
  EXPECT_EQ(format_of_channels(TexelFormat::kRgba16, 2), TexelFormat::kRg16);
  EXPECT_EQ(format_of_channels(TexelFormat::kR16, 4), TexelFormat::kRgba16);
  EXPECT_EQ(format_of_channels(TexelFormat::kRgba16Float, 1), TexelFormat::kR16Float);
  EXPECT_EQ(find_format_of_channels(TexelFormat::kR16, 3), std::nullopt);
  EXPECT_EQ(format_of_channels(TexelFormat::kR16Float, 2), TexelFormat::kRg16Float);
  EXPECT_EQ(format_of_channels(TexelFormat::kR32Float, 2), TexelFormat::kRg32Float);
  EXPECT_EQ(format_of_channels(TexelFormat::kRgba32Float, 1), TexelFormat::kR32Float);
  EXPECT_EQ(format_of_channels(TexelFormat::kBc5, 1), TexelFormat::kBc4);
  for (const TexelFormat same : {TexelFormat::kRgba16, TexelFormat::kBc5, TexelFormat::kBc7, TexelFormat::kRgb9e5})
    EXPECT_EQ(format_of_channels(same, format_info(same).channels), same);
}

}  // namespace
}  // namespace vt::channels
