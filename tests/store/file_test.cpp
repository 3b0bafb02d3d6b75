#include "store/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

// What a program prints after its caller has closed the standard streams must not land in a store.
TEST(File, NeverHasTheNumberOfAStandardStream) {
  const TempFolder folder;
  const auto path = folder / "a.vts";
  for (const bool is_new : {true, false}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) close(fd);
      auto writer = is_new ? StoreWriter::create(path, {}) : StoreWriter::open(path);
      if (!writer || !writer->add_layer(small_layer(is_new ? "a" : "b", TexelFormat::kRgb8, 2, 1))) _exit(3);
      constexpr std::string_view kText = "building elevation: 100 %  4096/4096 texels\n";
      for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) static_cast<void>(!pwrite(fd, kText.data(), kText.size(), 0));
      _exit(writer->finish() ? 0 : 4);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    const auto report = value_of(validate(path));
    for (const Finding& finding : report.findings) EXPECT_FALSE(finding.is_error) << finding.number << " " << finding.sentence;
  }
}

}  // namespace
}  // namespace vt::store
