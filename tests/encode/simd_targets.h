// Runs a test on every SIMD target of this machine.
#pragma once

#include <hwy/highway.h>

#include <cstdint>
#include <vector>

namespace vt::encode {

inline std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> found;
  const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
  for (const std::int64_t target : {HWY_SCALAR, HWY_EMU128, HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_AVX3_DL, HWY_NEON})
    if ((supported & target) != 0) found.push_back(target);
  return found;
}

// Lets the code for one target run, until it goes out of scope.
class ForcedTarget {
 public:
  explicit ForcedTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~ForcedTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ForcedTarget(const ForcedTarget&) = delete;
  ForcedTarget& operator=(const ForcedTarget&) = delete;
};

}  // namespace vt::encode
