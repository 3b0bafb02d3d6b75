// What the programs write for their users: whole, or not at all and said so; never through somebody else's
// link; never over what was not theirs.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <random>

#include "tests/cli/picture_file.h"
#include "tests/cli/vtinspect/run.h"
#include "tests/pipeline/small_builds.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class OutputFiles : public VtinspectTest {
 protected:
  // Noise, which no format makes small.
  void build(const std::string& channel) const {
    const bool is_height = channel == "elevation";
    pipeline::RasterSpec raster{.width = 96, .height = 80, .bands = is_height ? 1 : 3};
    raster.type = is_height ? SampleType::kFloat32 : SampleType::kUint8;
    std::mt19937 random(7);
    pipeline::write_raster(directory_ / "in.tif", raster, [&](std::int64_t, std::int64_t, int) { return random() % 256 + 0.0; });
    const Outcome built =
        run_program(VT_VTBUILD, {"layer", "in.tif", "-o", channel + ".vts", "--channel", channel, "--tile", "32", "--progress", "none"},
                    directory_.path());
    ASSERT_EQ(built.exit_code, 0) << built.err;
    std::filesystem::remove(directory_ / "in.tif");
  }
  // As on a disk with so much space left: `ulimit -f` counts in 512 bytes, and what a program says is less.
  [[nodiscard]] Outcome run_in(int blocks, const std::string& program, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"-c", "ulimit -f " + std::to_string(blocks) + "; exec \"$0\" \"$@\"", program});
    return run_program("/bin/sh", arguments, directory_.path());
  }
};

// 96 x 80 x 3 bytes of noise are more than 20 KiB in every format.
TEST_F(OutputFiles, APictureThatDoesNotFitIsAnErrorAndTheOldOneStays) {
  build("color");
  build("elevation");
  const std::vector<std::vector<std::string>> commands = {
      {"extract", "color.vts", "-o", "out.png"},     {"extract", "color.vts", "-o", "out.tif"},
      {"extract", "elevation.vts", "-o", "out.exr"}, {"extract", "elevation.vts", "-o", "out.tif"},
      {"extract", "elevation.vts", "-o", "out.png"}, {"extract", "color.vts", "--mosaic", "-o", "out.png"},
  };
  int met = 0;
  for (std::vector<std::string> command : commands) {
    const std::string out = command.back();
    SCOPED_TRACE(testing::PrintToString(command));
    command.insert(command.end(), {"--progress", "none"});
    // So little that the first write fails, that one in the middle does, and that the last ones do.
    for (const int blocks : {1, 9}) {
      for (const bool replaces : {false, true}) {
        std::filesystem::remove(directory_ / out);
        if (replaces) write_file(out, "older");
        const Outcome outcome = run_in(blocks, VT_VTINSPECT, command);
        EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
        EXPECT_THAT(outcome.err, AllOf(HasSubstr(out), HasSubstr("File too large"), HasSubstr("ulimit -f")));
        EXPECT_EQ(outcome.out, "") << "nothing was written, so nothing says so";
        EXPECT_EQ(content_of(directory_ / out), replaces ? "older" : "");
        EXPECT_EQ(std::filesystem::exists(directory_ / out), replaces);
        EXPECT_EQ(files().size(), replaces ? 3U : 2U) << "an unfinished file stayed";
        ++met;
      }
    }
    EXPECT_EQ(run_in(4096, VT_VTINSPECT, command).exit_code, 0);
    std::filesystem::remove(directory_ / out);
  }
  EXPECT_EQ(met, 24);
}

#ifdef VT_VTRENDER
TEST_F(OutputFiles, ARenderedPictureThatDoesNotFitIsAnError) {
  build("color");
  write_file("view.png", "older");
  const Outcome outcome = run_in(9, VT_VTRENDER, {"color.vts", "--size", "320x200", "-o", "view.png"});
  if (outcome.exit_code == 3 && outcome.err.find("context") != std::string::npos)
    GTEST_SKIP() << "no OpenGL context to be had here: " << outcome.err;
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("view.png"), HasSubstr("File too large")));
  EXPECT_EQ(content_of(directory_ / "view.png"), "older");
  EXPECT_THAT(files(), UnorderedElementsAre("color.vts", "view.png"));
}
#endif

TEST_F(OutputFiles, ADeviceThatIsFullIsAnError) {
  build("color");
  for (const std::string out : {"full.png", "full.tif"}) {
    std::filesystem::create_symlink("/dev/full", directory_ / out);
    const Outcome outcome = run({"extract", "color.vts", "-o", out});
    EXPECT_EQ(outcome.exit_code, 2) << out;
    EXPECT_THAT(outcome.err, HasSubstr(out)) << out;
    EXPECT_TRUE(std::filesystem::is_symlink(directory_ / out));
  }
}

TEST_F(OutputFiles, LinksAreFollowedAndPlantedOnesNot) {
  build("color");
  std::filesystem::create_directory(directory_ / "elsewhere");
  write_file("elsewhere/real.tif", "older");
  ASSERT_EQ(::chmod((directory_ / "elsewhere/real.tif").c_str(), 0600), 0);
  std::filesystem::create_symlink("elsewhere/real.tif", directory_ / "link.tif");
  // Names that this program's unfinished files had once.
  write_file("victim", "untouched");
  for (const char* name : {"link.tif.partial", "elsewhere/real.tif.partial", "out.png.partial", ".out.partial.png"})
    std::filesystem::create_symlink(directory_ / "victim", directory_ / name);
  EXPECT_EQ(run({"extract", "color.vts", "-o", "link.tif"}).exit_code, 0);
  EXPECT_EQ(run({"extract", "color.vts", "-o", "out.png"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(directory_ / "link.tif"));
  EXPECT_EQ(read_tiff(directory_ / "elsewhere/real.tif").width, 96);
  struct stat status = {};
  ASSERT_EQ(::stat((directory_ / "elsewhere/real.tif").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_EQ(content_of(directory_ / "victim"), "untouched");
}

TEST_F(OutputFiles, ASampleSceneReplacesSampleScenesAlone) {
  const auto sample = [&](std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"sample", "-o", ".", "--size", "64", "--progress", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(VT_VTBUILD, arguments, directory_.path());
  };
  write_file("imagery.tif", "my own");
  write_file("SCENE.json", R"({"format": "vt-scene", "version": 1, "name": "mine", "layers": []})");
  const Outcome refused = sample();
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("imagery.tif, SCENE.json"), HasSubstr("--force")));
  EXPECT_EQ(content_of(directory_ / "imagery.tif"), "my own");
  EXPECT_EQ(files().size(), 2U);

  EXPECT_EQ(sample({"--force"}).exit_code, 0);
  EXPECT_EQ(sample({"--seed", "2"}).exit_code, 0) << "a scene that was made here may be made anew";
  // What is younger than the scene that it belongs to was changed by somebody.
  write_file("materials.json", "edited");
  const auto scene_time = std::filesystem::last_write_time(directory_ / "SCENE.json");
  std::filesystem::last_write_time(directory_ / "materials.json", scene_time + std::chrono::seconds(5));
  const Outcome edited = sample();
  EXPECT_EQ(edited.exit_code, 2);
  EXPECT_THAT(edited.err, AllOf(HasSubstr("materials.json"), testing::Not(HasSubstr("imagery.tif"))));
  EXPECT_EQ(content_of(directory_ / "materials.json"), "edited");
}

}  // namespace
}  // namespace vt::test
