// Programs among others: standard streams that are closed, files that must not grow, what one command leaves
// for the next. Whatever it is, stores stay whole, nothing half-written stays behind, and the user is told.
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

// ---- What commands leave for the next one ----

TEST_F(ProcessTest, AFreshStoreValidatesWithoutARemark) {
  make_scene();
  ASSERT_EQ(shell("$VTBUILD dataset scene/SCENE.json -o a.vts --progress none").exit_code, 0);
  const Outcome validated = shell("$VTINSPECT validate a.vts --progress none");
  EXPECT_EQ(validated.exit_code, 0);
  EXPECT_THAT(validated.out, AllOf(HasSubstr("a.vts: valid"), HasSubstr("0 errors, 0 notes"), testing::Not(HasSubstr("note "))));
}

TEST_F(ProcessTest, UpdatesOfInputsWithOddNames) {
  make_scene();
  for (const std::string name : {"-dash.tif", "--output=x.tif", "layer", "dataset", "update", "a b'c.tif", "@not-a-list.tif"}) {
    const bool is_list = name[0] == '@';  // by its first letter; a path is none
    std::filesystem::copy_file(folder_ / "scene/elevation.tif", folder_ / name);
    std::vector<std::string> arguments = {
        "layer", "--channel", "elevation", "-o", "a.vts", "--progress", "none", "--", is_list ? "./" + name : name};
    const Outcome built = run_program(VT_VTBUILD, arguments, folder_.path());
    ASSERT_EQ(built.exit_code, 0) << name << ": " << built.err;
    const Outcome same = shell("$VTBUILD update a.vts --progress none");
    EXPECT_EQ(same.exit_code, 0) << name << ": " << same.err;
    EXPECT_EQ(shell("$VTINSPECT compare a.vts scene/elevation.tif --layer elevation --progress none").exit_code, 0) << name;
    shell("rm -f ./a.vts ./" + (name.find(' ') == std::string::npos ? name : "a*c.tif"));
  }
}

TEST_F(ProcessTest, LeftoversOfAKilledProgramAreNamedAndRemoved) {
  make_scene();
  ASSERT_EQ(shell("$VTBUILD layer scene/imagery.tif -o a.vts --channel color --progress none").exit_code, 0);
  for (const std::string next : {"$VTBUILD pack a.vts --keep-carry", "$VTBUILD layer scene/elevation.tif -o a.vts --channel elevation",
                                 "$VTBUILD remove a.vts elevation"}) {
    shell("head -c 20000 a.vts | tail -c 10000 > a.vts.new-0123456789abcdef");
    const Outcome outcome = shell(next);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("vtbuild: removed "),
                                   HasSubstr("a.vts.new-0123456789abcdef, which a program that was stopped had left\n")));
    EXPECT_THAT(files(), ElementsAre("a.vts", "scene"));
  }
}

// A mistyped command that fails leaves nothing behind that the right one would fall over.
TEST_F(ProcessTest, AStoreForDataThatCannotBeBuiltIsNotKept) {
  make_scene();
  const Outcome failed = shell("$VTBUILD layer scene/elevation.tif -o a.vts --channel material --progress none");
  EXPECT_EQ(failed.exit_code, 3) << failed.err;  // heights with fractions are no classes, which shows while they are read
  EXPECT_THAT(files(), ElementsAre("scene"));
  EXPECT_EQ(shell("$VTBUILD layer scene/elevation.tif -o a.vts --channel elevation --progress none").exit_code, 0);
}

TEST_F(ProcessTest, TheMemoryThatARefusalNamesIsEnough) {
  make_scene();
  for (const std::string threads : {"1", "40", "120"}) {
    const std::string build = "$VTBUILD dataset scene/SCENE.json -o a.vts --progress none --threads " + threads + " --memory ";
    const Outcome refused = shell(build + "13M");
    ASSERT_EQ(refused.exit_code, 1) << refused.err;
    const std::string words = "it needs --memory ";
    const std::size_t at = refused.err.find(words);
    ASSERT_NE(at, std::string::npos) << refused.err;
    const std::string named = refused.err.substr(at + words.size(), refused.err.find('M', at + words.size()) - at - words.size() + 1);
    const Outcome built = shell(build + named);
    EXPECT_EQ(built.exit_code, 0) << named << ": " << built.err;
    shell("rm -f a.vts");
  }
}

}  // namespace
}  // namespace vt::test
