#include "builder/text/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace vt::text {
namespace {

using testing::HasSubstr;

TEST(TextFile, ReadsWhatIsThereUpToItsLimit) {
  const test::TempFolder folder;
  std::ofstream(folder / "empty").close();
  const std::string long_text(200'000, 'x');
  std::ofstream(folder / "long") << long_text;
  EXPECT_EQ(read_text_file(folder / "empty", 10).value(), "");
  EXPECT_EQ(read_text_file(folder / "long", 200'000).value(), long_text);
  const auto refused = read_text_file(folder / "long", 199'999);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_THAT(refused.error().message, HasSubstr("long: is longer than 199999 bytes"));
}

TEST(TextFile, RefusesWhatIsNoFileAtOnce) {
  const test::TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const std::filesystem::path& path : {folder / "pipe", folder.path(), std::filesystem::path("/dev/zero")}) {
    const auto refused = read_text_file(path, 1000);
    ASSERT_FALSE(refused) << path;
    EXPECT_EQ(refused.error().code, ErrorCode::kIo);
    EXPECT_THAT(refused.error().message, HasSubstr(path.string() + ": is no file"));
  }
  EXPECT_THAT(read_text_file(folder / "none", 1000).error().message, HasSubstr("none: cannot be opened: No such file"));
}

}  // namespace
}  // namespace vt::text
