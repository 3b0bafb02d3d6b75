#include "builder/channels/coverage.h"

#include <gtest/gtest.h>

#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

// One coarse texel over a 2x2 footprint; value and weight are premultiplied planes.
struct Case {
  float filtered_value;
  float filtered_weight;
  std::array<float, 4> footprint_values;
  std::array<float, 4> footprint_weights;
};

std::pair<float, float> settle(const Case& c) {
  std::array<float, 2> upper_value{c.footprint_values[0], c.footprint_values[1]};
  std::array<float, 2> lower_value{c.footprint_values[2], c.footprint_values[3]};
  std::array<float, 2> upper_weight{c.footprint_weights[0], c.footprint_weights[1]};
  std::array<float, 2> lower_weight{c.footprint_weights[2], c.footprint_weights[3]};
  float value = c.filtered_value;
  float weight = c.filtered_weight;
  const PlaneRow out{&value, &weight};
  const bool opaque = settle_coverage({upper_value.data(), upper_weight.data()}, {lower_value.data(), lower_weight.data()},
                                      std::array{PlaneRule::kLinear, PlaneRule::kLinear}, 1, 1, out);
  EXPECT_EQ(opaque, weight == 1.0F);
  return {value, weight};
}

TEST(Coverage, FullTexelsStayAsFiltered) { EXPECT_EQ(settle({0.7F, 1.0F, {1, 1, 0, 0}, {1, 1, 1, 1}}), std::make_pair(0.7F, 1.0F)); }
TEST(Coverage, DataNeverGrowBeyondTheirFootprint) {
  EXPECT_EQ(settle({0.02F, 0.03F, {0, 0, 0, 0}, {0, 0, 0, 0}}), std::make_pair(0.0F, 0.0F));
}
TEST(Coverage, TheBoxTakesOverWhereTheLobesLeaveTooLittle) {
  EXPECT_EQ(settle({5.0F, 0.05F, {0.8F, 0, 0, 0}, {1, 0, 0, 0}}), std::make_pair(0.2F, 0.25F));
  EXPECT_EQ(settle({5.0F, -0.05F, {0.8F, 0, 0, 0}, {1, 0, 0, 0}}), std::make_pair(0.2F, 0.25F));
  EXPECT_EQ(settle({5.0F, std::numeric_limits<float>::quiet_NaN(), {0.8F, 0, 0, 0}, {1, 0, 0, 0}}), std::make_pair(0.2F, 0.25F));
}
TEST(Coverage, IsNeverMoreThanOne) { EXPECT_EQ(settle({0.54F, 1.08F, {1, 1, 1, 1}, {1, 1, 1, 1}}), std::make_pair(0.5F, 1.0F)); }

}  // namespace
}  // namespace vt::channels
