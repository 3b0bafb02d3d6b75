#include "builder/pipeline/parallel/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace vt::pipeline {
namespace {

TEST(ForEachIndex, DoesEveryStepOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> done(100);
    ASSERT_TRUE(for_each_index(done.size(), threads, [&](std::size_t i) -> Result<void> {
                  ++done[i];
                  return {};
                }).has_value());
    for (const auto& count : done) EXPECT_EQ(count, 1);
  }
  EXPECT_TRUE(for_each_index(0, 4, [](std::size_t) -> Result<void> { return fail(ErrorCode::kInternal, "never called"); }).has_value());
}

TEST(ForEachIndex, TellsTheFirstErrorInOrderHoweverLateItComes) {
  for (int round = 0; round < 20; ++round) {
    const auto result = for_each_index(64, 4, [](std::size_t i) -> Result<void> {
      if (i < 20) return {};
      if (i == 20) std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return fail(ErrorCode::kInvalidData, "step " + std::to_string(i));
    });
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().message, "step 20");
  }
}

TEST(ForEachIndex, AnExceptionIsAnErrorToo) {
  const auto result = for_each_index(3, 2, [](std::size_t) -> Result<void> { throw std::runtime_error("no memory"); });
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kInternal);
  EXPECT_EQ(result.error().message, "no memory");
  // What the system refuses is no fault of the program's.
  const auto refused = for_each_index(
      3, 2, [](std::size_t) -> Result<void> { throw std::system_error(std::make_error_code(std::errc::permission_denied)); });
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace vt::pipeline
