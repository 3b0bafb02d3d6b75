#include "builder/pyramid/reduce_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"
#include "tests/support/whole_image.h"

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

// Texels that are not all there, by the definition that whole images are held to.
TEST_P(ReduceRows, PartialRowsAreTheDefinitionBitForBit) {
  for (const HalvingKernel& kernel : {mitchell_kernel(), kaiser3_kernel(), kaiser5_kernel()})
    for (std::size_t count : {1U, 3U, 16U, 17U, 63U, 257U}) {
      const auto taps = static_cast<std::size_t>(kernel.taps);
      // Weights of runs of columns are 1, 0 or anything between; values without weight are 0.
      std::vector<std::vector<float>> weights;
      std::array<std::vector<std::vector<float>>, 2> values;
      for (std::size_t t = 0; t < taps; ++t) {
        std::vector<float> row = noise(count, static_cast<unsigned>(t) + 100);
        for (std::size_t i = 0; i < count; ++i)
          row[i] = i % 29 < 11 ? 1.0F : i % 29 < 14 ? 0.0F : row[i] < -0.3F ? 0.0F : row[i] > 0.5F ? 1.0F : 0.5F + row[i] / 2.0F;
        for (std::size_t p = 0; p < values.size(); ++p) {
          std::vector<float> plane = noise(count, static_cast<unsigned>(t + 40 * p) + 300);
          for (std::size_t i = 0; i < count; ++i) plane[i] *= row[i];
          values[p].push_back(std::move(plane));
        }
        weights.push_back(std::move(row));
      }
      std::vector<const float*> weight_rows;
      std::array<std::vector<const float*>, 2> value_rows;
      for (std::size_t t = 0; t < taps; ++t) {
        weight_rows.push_back(weights[t].data());
        for (std::size_t p = 0; p < values.size(); ++p) value_rows[p].push_back(values[p][t].data());
      }
      std::array<std::vector<float>, 2> out{std::vector<float>(count + 1, 42.0F), std::vector<float>(count + 1, 42.0F)};
      for (std::size_t p = 0; p < out.size(); ++p) combine_rows(value_rows[p].data(), kernel, count, out[p].data());
      const std::array<const float* const*, 2> planes{value_rows[0].data(), value_rows[1].data()};
      const std::array<float*, 2> results{out[0].data(), out[1].data()};
      combine_partial_rows(weight_rows.data(), planes, kernel, count, results.data());
      for (std::size_t p = 0; p < out.size(); ++p) {
        for (std::size_t i = 0; i < count; ++i) {
          test::Taps w{};
          test::Taps v{};
          for (std::size_t t = 0; t < taps; ++t) {
            w[t] = weights[t][i];
            v[t] = values[p][t][i];
          }
          ASSERT_EQ(out[p][i], test::filtered(kernel, v, w)) << kernel.name << " " << count << " " << i;
        }
        EXPECT_EQ(out[p][count], 42.0F) << "wrote past the end";
      }
    }
}

TEST_P(ReduceRows, APartialRowIsTheDefinitionBitForBit) {
  for (const HalvingKernel& kernel : {mitchell_kernel(), kaiser3_kernel(), kaiser5_kernel()})
    for (std::size_t count : {1U, 3U, 16U, 17U, 63U, 257U})
      for (const int holes : {0, 1, 2, 3}) {  // none, at the west end, at the east end, everywhere
        const auto margin = static_cast<std::size_t>(kernel.reach()) + 1;
        const std::size_t length = 2 * count + 2 * margin;
        std::vector<float> weights(length, 1.0F);
        const std::vector<float> chance = noise(length, 900);
        for (std::size_t i = 0; i < length; ++i)
          if ((holes == 1 && i < 9) || (holes == 2 && i + 9 > length) || (holes == 3 && i % 17 < 7))
            weights[i] = chance[i] < -0.2F ? 0.0F : chance[i] > 0.6F ? 1.0F : 0.4F + chance[i] / 2.0F;
        std::vector<float> values = noise(length, 901);
        for (std::size_t i = 0; i < length; ++i) values[i] *= weights[i];
        std::vector<float> out(count + 1, 42.0F);
        std::vector<float> scratch(2 * halve_scratch_floats(count));
        const float* const plane = values.data() + margin;
        float* const result = out.data();
        halve_row(plane, kernel, count, scratch.data(), result);
        halve_partial_row(weights.data() + margin, std::span(&plane, 1), kernel, count, scratch.data(), &result);
        for (std::size_t i = 0; i < count; ++i) {
          test::Taps w{};
          test::Taps v{};
          for (std::size_t t = 0; t < static_cast<std::size_t>(kernel.taps); ++t) {
            w[t] = weights[2 * i + t + 1];
            v[t] = values[2 * i + t + 1];
          }
          ASSERT_EQ(out[i], test::filtered(kernel, v, w)) << kernel.name << " " << count << " " << i << " holes " << holes;
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
