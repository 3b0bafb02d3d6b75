// What every subcommand of vtinspect does the same way: help, wrong usage, missing and damaged files, output
// that cannot be written.
#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// Each subcommand with the least it needs to look at `store`.
std::vector<std::vector<std::string>> all_subcommands(const std::string& store) {
  return {{"info", store},
          {"validate", store},
          {"extract", store, "--layer", "color", "-o", "out.png"},
          {"sample", store, "--layer", "color", "--uv", "0.5,0.5"},
          {"compare", store, store}};
}

TEST_F(VtinspectTest, HelpHasExamplesAndExitCodesEverywhere) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{}, {"info"}, {"validate"}, {"extract"}, {"sample"}, {"compare"}}) {
    std::vector<std::string> with_help = arguments;
    with_help.emplace_back("--help");
    const Outcome outcome = run(with_help);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("Examples:\n  vtinspect "), HasSubstr("Exit codes:")));
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(VtinspectTest, SaysItsVersion) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, StartsWith("vtinspect "));
}

TEST_F(VtinspectTest, RefusesWrongUsageWithExitCodeOne) {
  write_sample_store(directory_ / "s.vts");
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{},
                                             {"nonsense"},
                                             {"info"},
                                             {"info", "s.vts", "--nonsense"},
                                             {"extract", "s.vts", "--layer", "color"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.jpg"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.exr"},  // 8-bit codes
                                             {"extract", "s.vts", "-o", "out.png"},                      // two layers
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.png", "--window", "1,2,3"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.png", "--window", "1,2,3,4,5"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.png", "--window", "a,b,c,d"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.tif", "--mosaic"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.png", "--level", "x"},
                                             {"extract", "s.vts", "--layer", "color", "-o", "out.png", "--progress", "loud"},
                                             {"sample", "s.vts", "--layer", "color"},
                                             {"sample", "s.vts", "--layer", "color", "--uv", "0,0", "--texel", "0,0"},
                                             {"sample", "s.vts", "--layer", "color", "--uv", "0.5"},
                                             {"sample", "s.vts", "--layer", "color", "--uv", "nan,0.5"},
                                             {"sample", "s.vts", "--layer", "color", "--texel", "0.5,1"},
                                             {"compare", "s.vts"},
                                             {"compare", "s.vts", "s.vts", "--tolerance", "-1"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << testing::PrintToString(arguments) << outcome.err;
    EXPECT_THAT(outcome.err, StartsWith("vtinspect: "));
    EXPECT_EQ(outcome.out, "");
  }
  EXPECT_EQ(files(), std::vector<std::string>{"s.vts"});
}

TEST_F(VtinspectTest, NamesAMissingFile) {
  for (const auto& arguments : all_subcommands("missing.vts")) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments.front();
    EXPECT_THAT(outcome.err, AllOf(StartsWith("vtinspect: "), HasSubstr("missing.vts"))) << arguments.front();
    EXPECT_EQ(outcome.out, "") << arguments.front();
  }
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(VtinspectTest, RefusesWhatIsNotAStore) {
  write_file("empty.vts", "");
  write_file("text.vts", "This is not a store.\n");
  write_file("zeros.vts", std::string(100000, '\0'));
  for (const auto& arguments : all_subcommands("text.vts")) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 3) << arguments.front() << ' ' << outcome.err;
    EXPECT_THAT(outcome.out + outcome.err, HasSubstr("text.vts")) << arguments.front();
  }
  EXPECT_EQ(run({"info", "empty.vts"}).exit_code, 3);
  EXPECT_EQ(run({"info", "zeros.vts"}).exit_code, 3);
}

TEST_F(VtinspectTest, RefusesADirectory) {
  std::filesystem::create_directory(directory_ / "dir.vts");
  for (const auto& arguments : all_subcommands("dir.vts")) {
    const Outcome outcome = run(arguments);
    EXPECT_TRUE(outcome.exit_code == 2 || outcome.exit_code == 3) << arguments.front() << outcome.exit_code;
    EXPECT_THAT(outcome.err, HasSubstr("dir.vts")) << arguments.front();
  }
}

// Neither a crash nor a hang, whatever is cut off.
TEST_F(VtinspectTest, SurvivesTruncatedStores) {
  write_sample_store(directory_ / "s.vts");
  const auto size = std::filesystem::file_size(directory_ / "s.vts");
  for (const std::uintmax_t kept :
       {std::uintmax_t{1}, std::uintmax_t{100}, std::uintmax_t{4096}, std::uintmax_t{8192}, size / 2, size - 1}) {
    std::filesystem::copy_file(directory_ / "s.vts", directory_ / "cut.vts", std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(directory_ / "cut.vts", kept);
    const Outcome outcome = run({"extract", "cut.vts", "--layer", "color", "-o", "out.png"});
    EXPECT_THAT(outcome.exit_code, testing::AnyOf(0, 2, 3)) << kept << " bytes: " << outcome.err;
    EXPECT_EQ(run({"validate", "cut.vts"}).exit_code, 3) << kept << " of " << size << " bytes";
  }
}

TEST_F(VtinspectTest, ReportsADamagedTile) {
  write_sample_store(directory_ / "s.vts");
  flip_bit(directory_ / "s.vts", tile_offset(directory_ / "s.vts", "color", {Level{2}, 1, 1}) + 100);
  const Outcome extract = run({"extract", "s.vts", "--layer", "color", "-o", "out.png"});
  EXPECT_EQ(extract.exit_code, 3) << extract.err;
  EXPECT_THAT(extract.err, HasSubstr("s.vts"));
  EXPECT_EQ(files(), std::vector<std::string>{"s.vts"}) << "no half-written picture";
  EXPECT_EQ(run({"info", "s.vts"}).exit_code, 0) << "the index is whole";
}

TEST_F(VtinspectTest, EndsQuietlyWhenNobodyReads) {
  write_sample_store(directory_ / "s.vts");
  for (const auto& arguments : all_subcommands("s.vts")) {
    const Outcome outcome = run(arguments, StandardOutput::kClosedPipe);
    EXPECT_EQ(outcome.exit_code, 2) << arguments.front();
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("standard output"))) << arguments.front();
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("internal"))) << arguments.front();
  }
}

TEST_F(VtinspectTest, SaysThatStandardOutputIsFull) {
  write_sample_store(directory_ / "s.vts");
  const Outcome outcome = run({"info", "s.vts"}, StandardOutput::kFullDisk);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("vtinspect: standard output: cannot write: No space left on device"));
}

}  // namespace
}  // namespace vt::test
