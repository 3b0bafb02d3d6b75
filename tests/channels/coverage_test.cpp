#include "builder/channels/shared/coverage.h"

#include <gtest/gtest.h>

#include <array>

namespace vt::channels {
namespace {

constexpr std::array kRules{PlaneRule::kLinear, PlaneRule::kLinear};  // a value times its weight, and the weight

// One coarse texel over 4 x 4 fine ones, of which those at `places` have these values and weights.
struct Texel {
  int place;
  float value;
  float weight;
};

std::pair<float, float> limited(float value, float weight, const std::vector<Texel>& texels) {
  std::array<std::array<float, 4>, 4> values{};
  std::array<std::array<float, 4>, 4> weights{};
  for (const Texel& texel : texels) {
    const auto y = static_cast<std::size_t>(texel.place / 4);
    const auto x = static_cast<std::size_t>(texel.place % 4);
    values[y][x] = texel.value * texel.weight;
    weights[y][x] = texel.weight;
  }
  std::array<ConstPlaneRow, 4> rows{};
  for (std::size_t y = 0; y < 4; ++y) rows[y] = {values[y].data() + 1, weights[y].data() + 1};
  limit_to_covered(rows, kRules, 1, 1, {&value, &weight});
  return {value, weight};
}

TEST(Coverage, ValuesMoveBetweenThoseOfTexelsWithData) {
  EXPECT_EQ(limited(0.9F, 1.0F, {{5, 0.25F, 1.0F}, {6, 0.75F, 1.0F}}), std::pair(0.75F, 1.0F));
  EXPECT_EQ(limited(0.1F, 1.0F, {{0, 0.25F, 1.0F}, {15, 0.75F, 1.0F}}), std::pair(0.25F, 1.0F)) << "also of the outermost";
  EXPECT_EQ(limited(0.5F, 1.0F, {{5, 0.25F, 1.0F}, {6, 0.75F, 1.0F}}), std::pair(0.5F, 1.0F));
}

TEST(Coverage, TexelsWithoutDataHaveNoSay) { EXPECT_EQ(limited(0.1F, 1.0F, {{5, 0.5F, 1.0F}, {6, 0.0F, 0.0F}}), std::pair(0.5F, 1.0F)); }

TEST(Coverage, OfPartlyCoveredTexelsTheColourIsLimitedAndTheWeightStays) {
  EXPECT_EQ(limited(0.5F, 0.5F, {{5, 0.25F, 0.5F}, {6, 0.75F, 0.25F}}), std::pair(0.375F, 0.5F));
  EXPECT_EQ(limited(0.0F, 0.0F, {{5, 0.25F, 1.0F}}), std::pair(0.0F, 0.0F)) << "nothing stays nothing";
}

}  // namespace
}  // namespace vt::channels
