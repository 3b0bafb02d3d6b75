// What the world around a program may do to it: standard streams that are closed, files that must not grow. Whatever it is, stores stay
// whole, nothing half-written stays behind, and the user is told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/cli/picture_file.h"
#include "tests/cli/program_run.h"
#include "tests/support/temp_folder.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ProcessTest : public testing::Test {
 protected:
  // `command` as a shell understands it, with $VTBUILD, $VTINSPECT and $VTRENDER.
  Outcome shell(const std::string& command) {
    std::string text = std::string("VTBUILD='") + VT_VTBUILD + "'; VTINSPECT='" + VT_VTINSPECT + "'; ";
#ifdef VT_VTRENDER
    text += std::string("VTRENDER='") + VT_VTRENDER + "'; ";
#endif
    return run_program("/bin/sh", {"-c", text + command}, folder_.path());
  }
  void make_scene() { ASSERT_EQ(shell("$VTBUILD sample -o scene --size 256 --progress none").exit_code, 0); }
  std::vector<std::string> files() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  TempFolder folder_;
};

TEST_F(ProcessTest, ClosedStandardStreamsLeadToNoFile) {
  make_scene();
  for (const std::string closed : {">&- 2>&-", "<&- >&- 2>&-", "<&-", "2>&-"}) {
    const std::string build = "$VTBUILD layer scene/imagery.tif -o a.vts --channel color --progress plain --checkpoint 0.01 ";
    EXPECT_EQ(shell(build + closed).exit_code, 0) << closed;
    EXPECT_EQ(shell("$VTBUILD layer scene/elevation.tif -o a.vts --channel elevation --progress plain " + closed).exit_code, 0) << closed;
    EXPECT_EQ(shell("$VTBUILD pack a.vts --keep-carry --progress plain " + closed).exit_code, 0) << closed;
    EXPECT_EQ(shell("$VTINSPECT validate a.vts").exit_code, 0) << closed;
    EXPECT_EQ(shell("$VTINSPECT extract a.vts --layer color -o a.png --progress plain " + closed).exit_code, 0) << closed;
    EXPECT_EQ(read_png(folder_ / "a.png").width, 256) << closed;
#ifdef VT_VTRENDER
    const Outcome drawn = shell("$VTRENDER a.vts --size 64x36 -o view.png " + closed);
    if (drawn.exit_code == 0) {
      EXPECT_EQ(read_png(folder_ / "view.png").width, 64) << closed;
    }
#endif
    shell("rm -f a.vts a.png view.png");
  }
}

// `ulimit -f` sends a signal whose default action kills; to a user it is a disk that is full.
TEST_F(ProcessTest, AFileOverItsSizeLimitIsLikeAFullDisk) {
  make_scene();
  const std::string build = "$VTBUILD layer scene/imagery.tif -o a.vts --channel color --compression none --progress none";
  const Outcome refused = shell("ulimit -f 100; " + build);
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("a.vts: cannot write: File too large"), HasSubstr("ulimit -f"), HasSubstr("run the same command again")));
  EXPECT_THAT(files(), ElementsAre("a.vts", "scene"));
  EXPECT_EQ(shell("$VTINSPECT validate a.vts").exit_code, 0);
  ASSERT_EQ(shell(build).exit_code, 0);

  const Outcome packed = shell("ulimit -f 100; $VTBUILD pack a.vts -o b.vts --progress none");
  EXPECT_EQ(packed.exit_code, 2) << packed.err;
  EXPECT_THAT(packed.err, HasSubstr("cannot write: File too large"));
  const Outcome in_place = shell("ulimit -f 100; $VTBUILD pack a.vts --progress none");
  EXPECT_EQ(in_place.exit_code, 2) << in_place.err;
  EXPECT_THAT(files(), ElementsAre("a.vts", "scene"));
  EXPECT_EQ(shell("$VTINSPECT compare a.vts scene/imagery.tif").exit_code, 0);
}

}  // namespace
}  // namespace vt::test
