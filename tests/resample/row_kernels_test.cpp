#include "builder/resample/rows/row_kernels.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"

namespace vt::resample {
namespace {

class RowKernels : public test::OnEveryCpuTarget {};

// Every length up to a few vectors, from every offset: bit for bit what the plain loop gives.
TEST_P(RowKernels, AddWhatThePlainLoopAdds) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> any(-1e3F, 1e3F);
  std::vector<float> values(200);
  for (float& value : values) value = any(random);
  for (std::size_t count = 0; count < 70; ++count)
    for (std::size_t offset = 0; offset < 9; ++offset) {
      std::vector<double> sums(100);
      for (double& sum : sums) sum = static_cast<double>(any(random));
      std::vector<double> wanted = sums;
      const double weight = static_cast<double>(any(random)) / 1e3;
      for (std::size_t i = 0; i < count; ++i) wanted[offset + i] += weight * static_cast<double>(values[offset + i]);
      add_weighted(values.data() + offset, weight, count, sums.data() + offset);
      ASSERT_EQ(sums, wanted) << count << " from " << offset;
    }
}

TEST_P(RowKernels, InterpolateAsThePlainLoopDoes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1e3F, 1e3F);
  std::uniform_real_distribution<float> fraction(0.0F, 1.0F);
  std::vector<float> north(200);
  std::vector<float> south(200);
  std::vector<float> fx(200);
  std::vector<float> fy(200);
  for (std::size_t i = 0; i < north.size(); ++i) {
    north[i] = any(random);
    south[i] = any(random);
    fx[i] = fraction(random);
    fy[i] = fraction(random);
  }
  for (std::size_t count = 0; count < 70; ++count)
    for (std::size_t offset = 0; offset < 9; ++offset)
      for (const std::size_t next : {0, 1}) {
        std::vector<float> out(100, -7.0F);
        std::vector<float> wanted = out;
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t at = offset + i;
          const float n = north[at] + fx[at] * (north[at + next] - north[at]);
          const float s = south[at] + fx[at] * (south[at + next] - south[at]);
          wanted[at] = n + fy[at] * (s - n);
        }
        const auto from = [&](const std::vector<float>& row, std::size_t more = 0) { return row.data() + offset + more; };
        interpolate({from(fx), from(fy), from(north), from(north, next), from(south), from(south, next)}, count, out.data() + offset);
        ASSERT_EQ(out, wanted) << count << " from " << offset;
      }
}

VT_ON_EVERY_CPU_TARGET(RowKernels);

}  // namespace
}  // namespace vt::resample
