#include "builder/pyramid/reduce_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"

namespace vt::pyramid {
namespace {

// The definition, one value at a time, in the order that the header promises.
template <class At>
float weighted_pairs(const HalvingKernel& kernel, const At& at) {
  float sum = kernel.weight[0] * (at(0) + at(kernel.taps - 1));
  for (int t = 1; t < kernel.taps / 2; ++t) sum = sum + kernel.weight[static_cast<std::size_t>(t)] * (at(t) + at(kernel.taps - 1 - t));
  return sum;
}

std::vector<float> noise(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  std::vector<float> values(count);
  for (float& v : values) v = uniform(random);
  return values;
}

class ReduceRows : public test::OnEveryCpuTarget {};

TEST_P(ReduceRows, CombineIsTheDefinitionBitForBit) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()})
    for (std::size_t count : {1U, 3U, 16U, 17U, 63U, 257U}) {
      std::vector<std::vector<float>> rows;
      std::vector<const float*> pointers;
      for (int t = 0; t < kernel.taps; ++t) rows.push_back(noise(count, static_cast<unsigned>(t) + 7));
      for (const auto& row : rows) pointers.push_back(row.data());
      std::vector<float> out(count + 1, 42.0F);
      combine_rows(pointers.data(), kernel, count, out.data());
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(out[i], weighted_pairs(kernel, [&](int t) { return rows[static_cast<std::size_t>(t)][i]; }))
            << kernel.name << " " << count << " " << i;
      EXPECT_EQ(out[count], 42.0F) << "wrote past the end";
    }
}

TEST_P(ReduceRows, HalveIsTheDefinitionBitForBit) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()})
    for (std::size_t count : {1U, 3U, 16U, 17U, 63U, 257U}) {
      const int reach = kernel.reach();
      const std::vector<float> padded = noise(2 * count + 2 * static_cast<std::size_t>(reach) + 2, 3);
      const float* row = padded.data() + reach + 1;
      std::vector<float> out(count + 1, 42.0F);
      std::vector<float> scratch(halve_scratch_floats(count));
      halve_row(row, kernel, count, scratch.data(), out.data());
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(out[i], weighted_pairs(kernel, [&](int t) { return row[2 * static_cast<std::ptrdiff_t>(i) - reach + t]; }))
            << kernel.name << " " << i;
      EXPECT_EQ(out[count], 42.0F) << "wrote past the end";
    }
}

TEST_P(ReduceRows, TwoRowsAtOnceAreCombineThenHalveBitForBit) {
  const HalvingKernel& kernel = box_kernel();
  for (std::size_t count : {1U, 3U, 16U, 17U, 63U, 257U}) {
    const std::vector<float> upper = noise(2 * count, 11);
    const std::vector<float> lower = noise(2 * count, 12);
    std::vector<float> out(count + 1, 42.0F);
    halve_two_rows(upper.data(), lower.data(), kernel, count, out.data());
    for (std::size_t i = 0; i < count; ++i) {
      const auto combined = [&](std::size_t x) { return weighted_pairs(kernel, [&](int t) { return (t == 0 ? upper : lower)[x]; }); };
      ASSERT_EQ(out[i], weighted_pairs(kernel, [&](int t) { return combined(2 * i + static_cast<std::size_t>(t)); })) << count << " " << i;
    }
    EXPECT_EQ(out[count], 42.0F) << "wrote past the end";
  }
}

TEST_P(ReduceRows, RoundingStaysWithinWhatTwelveProductsAllow) {
  const HalvingKernel& kernel = kaiser3_kernel();
  const std::size_t count = 500;
  const std::vector<float> padded = noise(2 * count + 12, 5);
  const float* row = padded.data() + kernel.reach() + 1;
  std::vector<float> out(count);
  std::vector<float> scratch(halve_scratch_floats(count));
  halve_row(row, kernel, count, scratch.data(), out.data());
  for (std::size_t i = 0; i < count; ++i) {
    long double exact = 0.0L;
    long double magnitude = 0.0L;
    for (int t = 0; t < kernel.taps; ++t) {
      const long double product = static_cast<long double>(kernel.weight[static_cast<std::size_t>(t)]) *
                                  row[2 * static_cast<std::ptrdiff_t>(i) - kernel.reach() + t];
      exact += product;
      magnitude += std::abs(product);
    }
    // 6 pair sums, 6 products, 5 additions: each rounds by at most 2^-24 of what it holds.
    EXPECT_NEAR(out[i], static_cast<double>(exact), 7 * 0x1p-24 * static_cast<double>(magnitude));
  }
}

VT_ON_EVERY_CPU_TARGET(ReduceRows);

}  // namespace
}  // namespace vt::pyramid
