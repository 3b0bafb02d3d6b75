#include "builder/channels/shared/unorm_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"

namespace vt::channels {
namespace {

class UnormRows : public test::OnEveryCpuTarget {};

TEST_P(UnormRows, AreTheNearestCodesOfTheRange) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> any(-1.3F, 1.3F);
  std::vector<float> values{-1.0F, 1.0F, 0.0F, -0.0F, 1e30F, -1e30F, std::numeric_limits<float>::infinity()};
  while (values.size() < 1003) values.push_back(any(random));
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kRg16, TexelFormat::kBc5})
    for (const int first : {0, 1}) {
      const UnormCode code = unorm_code(format, -1.0, 1.0, first);
      std::vector<std::uint16_t> codes(values.size());
      unorm_codes(code, values.size(), values.data(), codes.data());
      const bool is_block = format == TexelFormat::kBc5;
      const double last = format == TexelFormat::kRg16 ? 65535.0 : 255.0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_EQ(codes[i], code.code(values[i])) << i;
        const double clamped = std::min(std::max(static_cast<double>(values[i]), -1.0), 1.0);
        const double exact = (is_block ? 257.0 : 1.0) * (first + (clamped + 1.0) / 2.0 * (last - first));
        EXPECT_NEAR(codes[i], exact, 0.5 + 0x1p-7) << "floats near 65535 are 2^-8 apart, and two roundings are made";
        // What is read back is within half a step too.
        EXPECT_NEAR(code.value(static_cast<float>(codes[i]) / (is_block ? 257.0F : 1.0F)), clamped, 0.51 * code.step());
      }
    }
}

VT_ON_EVERY_CPU_TARGET(UnormRows);

}  // namespace
}  // namespace vt::channels
