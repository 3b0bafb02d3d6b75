#include "store/io/output_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/store/store_support.h"
#include "tests/support/temp_folder.h"

namespace vt::store {
namespace {

using test::names_in;
using test::TempFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void put(const std::filesystem::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

mode_t mode_of(const std::filesystem::path& path) {
  struct stat status = {};
  return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

// Both ways in which an unfinished file can be there.
class OutputFileTest : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] OutputFile::Options options() const { return {.may_be_unnamed = GetParam()}; }
  TempFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Ways, OutputFileTest, testing::Bool(), [](const auto& way) { return way.param ? "Unnamed" : "RandomName"; });

TEST_P(OutputFileTest, IsSeenOnlyWhenItIsWhole) {
  put(folder_ / "a.txt", "old");
  auto file = OutputFile::create(folder_ / "a.txt", options());
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE(file->append(bytes_of("hello ")));
  ASSERT_TRUE(file->append(bytes_of("world")));
  EXPECT_EQ(content(folder_ / "a.txt"), "old");
  ASSERT_TRUE(file->finish());
  EXPECT_EQ(content(folder_ / "a.txt"), "hello world");
  EXPECT_THAT(names_in(folder_.path()), ElementsAre("a.txt"));
}

TEST_P(OutputFileTest, IsGoneWhenItIsNotFinished) {
  put(folder_ / "a.txt", "old");
  {
    auto file = OutputFile::create(folder_ / "a.txt", options());
    ASSERT_TRUE(file && file->append(std::vector<std::byte>(3 << 20)));
    OutputFile moved = std::move(*file);
  }
  EXPECT_EQ(content(folder_ / "a.txt"), "old");
  EXPECT_THAT(names_in(folder_.path()), ElementsAre("a.txt"));
}

TEST_P(OutputFileTest, WritesAndReadsAnywhere) {
  auto file = OutputFile::create(folder_ / "a", options());
  ASSERT_TRUE(file);
  // Larger than the buffer, then inside what is still in it, then inside what is not, then past a gap.
  ASSERT_TRUE(file->append(std::vector<std::byte>(std::size_t{5} << 19, std::byte{'x'})));
  ASSERT_TRUE(file->append(bytes_of("0123456789")));
  ASSERT_TRUE(file->write_at((5 << 19) + 2, bytes_of("ab")));
  ASSERT_TRUE(file->write_at(1, bytes_of("yz")));
  ASSERT_TRUE(file->write_at((5 << 19) + 12, bytes_of("end")));
  EXPECT_EQ(file->size(), (5U << 19) + 15);
  std::array<std::byte, 8> four{};
  EXPECT_EQ(*file->read_at((5 << 19) + 8, four), 7U);
  EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(four.data()), 7), std::string_view("89\0\0end", 7));
  ASSERT_TRUE(file->finish());
  const std::string written = content(folder_ / "a");
  EXPECT_EQ(written.substr(0, 4), "xyzx");
  EXPECT_EQ(written.substr(5 << 19), std::string("01ab456789\0\0end", 15));
}

TEST_P(OutputFileTest, HasTheModeOfItsTargetFromTheStartAndTheUmaskOtherwise) {
  put(folder_ / "secret", "old");
  ASSERT_EQ(::chmod((folder_ / "secret").c_str(), 0640), 0);
  const mode_t umask_before = ::umask(0022);
  auto secret = OutputFile::create(folder_ / "secret", options());
  auto fresh = OutputFile::create(folder_ / "fresh", options());
  ASSERT_TRUE(secret && fresh);
  // What lies beside the target is never more readable than the target.
  for (const std::string& name : names_in(folder_.path())) {
    if (!name.starts_with(".vt-")) continue;
    EXPECT_THAT((std::vector<mode_t>{0640, 0644}), testing::Contains(mode_of(folder_ / name))) << name;
  }
  ASSERT_TRUE(secret->append(bytes_of("x")) && secret->finish() && fresh->finish());
  ::umask(umask_before);
  EXPECT_EQ(mode_of(folder_ / "secret"), 0640U);
  EXPECT_EQ(mode_of(folder_ / "fresh"), 0644U);
}

TEST_P(OutputFileTest, KeepsTheOwnerOfItsTarget) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  put(folder_ / "theirs", "old");
  ASSERT_EQ(::chown((folder_ / "theirs").c_str(), 12345, 23456), 0);
  auto file = OutputFile::create(folder_ / "theirs", options());
  ASSERT_TRUE(file && file->finish());
  struct stat status = {};
  ASSERT_EQ(::stat((folder_ / "theirs").c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 12345U);
  EXPECT_EQ(status.st_gid, 23456U);
}

TEST_P(OutputFileTest, FollowsALinkAndLeavesItThere) {
  std::filesystem::create_directory(folder_ / "far");
  put(folder_ / "far/target.txt", "old");
  std::filesystem::create_symlink("far/target.txt", folder_ / "link.txt");
  std::filesystem::create_symlink("link.txt", folder_ / "link of link.txt");
  auto file = OutputFile::create(folder_ / "link of link.txt", options());
  ASSERT_TRUE(file && file->append(bytes_of("new")) && file->finish());
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.txt"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link of link.txt"));
  EXPECT_FALSE(std::filesystem::is_symlink(folder_ / "far/target.txt"));
  EXPECT_EQ(content(folder_ / "far/target.txt"), "new");

  std::filesystem::create_symlink("far/not yet.txt", folder_ / "dangling.txt");
  EXPECT_TRUE(write_whole_file(folder_ / "dangling.txt", "made"));
  EXPECT_EQ(content(folder_ / "far/not yet.txt"), "made");

  std::filesystem::create_symlink("round.txt", folder_ / "round.txt");
  EXPECT_FALSE(write_whole_file(folder_ / "round.txt", ""));
}

TEST_P(OutputFileTest, DoesNotFollowALinkThatAStrangerPutIntoASharedFolder) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make a stranger's link";
  std::filesystem::create_directory(folder_ / "shared");
  ASSERT_EQ(::chmod((folder_ / "shared").c_str(), 01777), 0);
  put(folder_ / "victim", "old");
  std::filesystem::create_symlink(folder_ / "victim", folder_ / "shared/out.txt");
  EXPECT_TRUE(OutputFile::create(folder_ / "shared/out.txt", options())) << "a link of one's own is followed";
  ASSERT_EQ(::lchown((folder_ / "shared/out.txt").c_str(), 12345, 12345), 0);
  const auto refused = OutputFile::create(folder_ / "shared/out.txt", options());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_EQ(content(folder_ / "victim"), "old");
}

TEST_P(OutputFileTest, TwoWritersOfOneTargetNeverMix) {
  const std::string a(1 << 21, 'a');
  const std::string b(1 << 20, 'b');
  auto first = OutputFile::create(folder_ / "o", options());
  auto second = OutputFile::create(folder_ / "o", options());
  ASSERT_TRUE(first && second);
  ASSERT_TRUE(first->append(bytes_of(a)) && second->append(bytes_of(b)));
  ASSERT_TRUE(first->finish());
  EXPECT_EQ(content(folder_ / "o"), a);
  ASSERT_TRUE(second->finish());
  EXPECT_EQ(content(folder_ / "o"), b);
  EXPECT_THAT(names_in(folder_.path()), ElementsAre("o"));
}

// A process of its own, so that the limit is its own too. Returns what finish() said.
std::string message_at_a_limit(const std::filesystem::path& path, rlim_t most_bytes, const OutputFile::Options& options) {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) return "no pipe";
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{most_bytes, most_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const auto said = [&]() -> std::string {
      auto file = OutputFile::create(path, options);
      // As a library does that looks at nothing that it is told.
      for (int i = 0; file && i < 100; ++i) static_cast<void>(file->append(std::vector<std::byte>(100)));
      const Result<void> finished = file ? file->finish() : tl::unexpected(file.error());
      return finished ? "whole" : finished.error().message;
    }();
    static_cast<void>(!::write(pipe[1], said.data(), said.size()));
    ::_exit(0);
  }
  ::close(pipe[1]);
  std::string said(4096, '\0');
  const ssize_t length = ::read(pipe[0], said.data(), said.size());
  ::close(pipe[0]);
  ::waitpid(child, nullptr, 0);
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  return said;
}

TEST_P(OutputFileTest, AFailedWriteIsTheResultHoweverFewLook) {
  put(folder_ / "o", "old");
  EXPECT_EQ(message_at_a_limit(folder_ / "new", 10000, options()), "whole");
  EXPECT_THAT(message_at_a_limit(folder_ / "o", 9999, options()),
              HasSubstr("cannot write: File too large; raise the limit on the size of files (ulimit -f)"));
  EXPECT_EQ(content(folder_ / "o"), "old");
  EXPECT_THAT(names_in(folder_.path()), ElementsAre("new", "o"));
}

TEST(OutputFile, ADeviceIsWrittenToAndNotReplaced) {
  const TempFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.csv");
  const auto full = write_whole_file(folder / "full.csv", "x");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kIo);
  EXPECT_THAT(full.error().message, HasSubstr("full.csv: cannot write: No space left on device"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "full.csv"));
  EXPECT_TRUE(write_whole_file("/dev/null", "x"));
  struct stat status = {};
  ASSERT_EQ(::stat("/dev/null", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

TEST(OutputFile, APipeThatNobodyReadsIsRefusedAtOnce) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(write_whole_file(folder / "pipe", "x").error().message, HasSubstr("pipe: cannot open: No such device"));

  const int reader = ::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK);
  EXPECT_TRUE(write_whole_file(folder / "pipe", "hello"));
  std::array<char, 8> read{};
  EXPECT_EQ(::read(reader, read.data(), read.size()), 5);
  ::close(reader);
}

TEST(OutputFile, SaysWhatIsWrongWithAPlace) {
  const TempFolder folder;
  EXPECT_THAT(write_whole_file(folder.path(), "x").error().message, HasSubstr("cannot create: Is a directory"));
  EXPECT_THAT(write_whole_file(folder / "no/such/file", "x").error().message, HasSubstr("cannot create: No such file or directory"));
  // As long as a name may be.
  EXPECT_TRUE(write_whole_file(folder / std::string(255, 'n'), "x"));
  EXPECT_THAT(names_in(folder.path()), ElementsAre(std::string(255, 'n')));
}

}  // namespace
}  // namespace vt::store
