#include "store/io/file.h"

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

// A name that another file has got is not removed with the file that had it.
TEST(File, RemovesItsNameOnlyWhileItHasIt) {
  const TempFolder folder;
  write_file(folder / "kept", tile_bytes(small_layer("a", TexelFormat::kRgb8, 2, 1), tile_at(0, 0, 0)));
  const File file = value_of(File::open(folder / "own", File::Mode::kCreate));
  std::filesystem::rename(folder / "kept", folder / "own");
  file.remove_own_name();
  EXPECT_TRUE(std::filesystem::exists(folder / "own"));
  const File other = value_of(File::open(folder / "other", File::Mode::kCreate));
  other.remove_own_name();
  EXPECT_FALSE(std::filesystem::exists(folder / "other"));
}

}  // namespace
}  // namespace vt::store
