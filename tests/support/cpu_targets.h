// Runs a parameterised suite once for each vector unit that the SIMD loops are compiled for and this
// processor has.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <string>

namespace vt::test {

class OnEveryCpuTarget : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override {
    if ((hwy::SupportedTargets() & GetParam()) == 0) GTEST_SKIP() << "this processor has no " << hwy::TargetName(GetParam());
    use_targets(GetParam());
  }
  void TearDown() override { use_targets(0); }

 private:
  static void use_targets(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

}  // namespace vt::test

#define VT_ON_EVERY_CPU_TARGET(suite)                                                                             \
  INSTANTIATE_TEST_SUITE_P(Targets, suite, testing::Values(HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_AVX3_DL), \
                           [](const auto& target) { return std::string(hwy::TargetName(target.param)); })
