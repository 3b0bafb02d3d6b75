// Texts, names, files and sizes that nobody means well with: a sentence and the code of the user's error, at
// once, and nothing raw on the terminal.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "store/format/text.h"
#include "store/store_writer.h"
#include "tests/cli/vtinspect/run.h"
#include "tests/pipeline/small_builds.h"

#ifndef __has_feature
#define __has_feature(feature) 0
#endif

namespace vt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kEscape =
    "\x1b]0;owned\x07\xc2\x9b"
    "31m\xe2\x80\xae\x7f";

class HostileInput : public VtinspectTest {
 protected:
  // A layer of one texel whose metadata, and the store's, are these.
  void write_store(const std::string& dataset_json, const std::string& layer_json) const {
    std::filesystem::remove(directory_ / "s.vts");
    auto writer =
        store::StoreWriter::create(directory_ / "s.vts", {.area = {0.0, 0.0, 16.0, 16.0}, .metadata_json = dataset_json}, {.sync = false});
    ASSERT_TRUE(writer) << writer.error().message;
    LayerInfo layer{.name = "cover", .channel = ChannelType::kMaterial, .format = TexelFormat::kR8};
    layer.tile_exponent = 4;
    layer.data = {0, 0, 16, 16};
    layer.grid = {.origin_x = 0.0, .origin_y = 16.0};
    layer.state = LayerState::kComplete;
    layer.metadata_json = layer_json;
    const auto id = writer->add_layer(layer);
    ASSERT_TRUE(id) << id.error().message;
    const std::byte one{1};
    ASSERT_TRUE(writer->put_constant(*id, {}, std::span(&one, 1)));
    ASSERT_TRUE(writer->finish());
  }
  // As wide as a store can be, and empty.
  void write_huge_store() const {
    auto writer = store::StoreWriter::create(directory_ / "huge.vts", {.area = {0.0, 0.0, 1.0, 1.0}}, {.sync = false});
    ASSERT_TRUE(writer);
    LayerInfo layer{.name = "color"};
    layer.finest = Level{23};
    layer.data = {0, 0, std::int64_t{1} << 31, std::int64_t{1} << 31};
    layer.grid = {.origin_x = 0.0, .origin_y = 1.0, .step_x = 0x1p-31, .step_y = 0x1p-31};
    layer.state = LayerState::kComplete;
    ASSERT_TRUE(writer->add_layer(layer));
    ASSERT_TRUE(writer->finish());
  }
  [[nodiscard]] Outcome build(const std::vector<std::string>& arguments) const {
    return run_program(VT_VTBUILD, arguments, directory_.path());
  }
};

void expect_plain(const Outcome& outcome) {
  for (const std::string& text : {outcome.out, outcome.err}) {
    std::string one_line = text;
    std::erase(one_line, '\n');
    std::erase(one_line, '\t');
    EXPECT_TRUE(store::is_plain_text(one_line)) << text;
  }
}

TEST_F(HostileInput, DeepMetadataAreNoJsonAndNoDanger) {
  for (const std::size_t depth : {65U, 40'000U, 200'000U}) {
    const std::string deep = "{\"x\":" + std::string(depth, '[') + std::string(depth, ']') + "}";
    write_store(deep, deep);
    const Outcome text = run({"info", "s.vts"});
    EXPECT_EQ(text.exit_code, 0) << text.err;
    EXPECT_THAT(text.err, HasSubstr("more than 64 deep"));
    const auto json = run_json("vtinspect-info", {"info", "s.vts"});
    EXPECT_EQ(json["layers"][0]["metadata"], deep) << "shown as the text that it is";
    // No CRS can be read out of it: that is an error of the data where a place on the Earth is needed.
    EXPECT_EQ(run({"sample", "s.vts", "--texel", "0,0"}).exit_code, 3);
    EXPECT_EQ(run({"extract", "s.vts", "-o", "out.tif"}).exit_code, 3);
  }
}

TEST_F(HostileInput, DeepScenesAndTablesAreRefused) {
  pipeline::write_raster(directory_ / "in.tif", {.width = 20, .height = 20, .bands = 1}, [](auto, auto, int) { return 1.0; });
  for (const std::size_t depth : {65U, 200'000U}) {
    const std::string deep(depth, '[');
    write_file("SCENE.json", deep + std::string(depth, ']'));
    write_file("table.json", deep + std::string(depth, ']'));
    const std::vector<std::vector<std::string>> commands = {
        {"dataset", "SCENE.json", "-o", "x.vts"},
        {"layer", "in.tif", "-o", "x.vts", "--channel", "material", "--classes", "table.json"},
        {"layer", "in.tif", "-o", "x.vts", "--channel", "sensor", "--basis", "table.json"},
    };
    for (const auto& command : commands) {
      const Outcome outcome = build(command);
      EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("more than 64 deep"));
      EXPECT_FALSE(std::filesystem::exists(directory_ / "x.vts"));
    }
  }
  write_file("response.json", "{\"wavelength_um\":" + std::string(100'000, '['));
  const Outcome response =
      build({"layer", "in.tif", "-o", "x.vts", "--channel", "sensor", "--quantity", "temperature", "--response", "response.json"});
  EXPECT_EQ(response.exit_code, 3) << response.err;
  EXPECT_THAT(response.err, HasSubstr("more than 64 deep"));
}

TEST_F(HostileInput, ANumberThatNoDoubleHoldsIsAnErrorOfTheScene) {
  write_file(
      "SCENE.json",
      R"({"format":"vt-scene","version":1,"name":"x","layers":[{"name":"c","channel":"elevation","sources":["in.tif"],"range":[0,1e999]}]})");
  const Outcome outcome = build({"dataset", "SCENE.json", "-o", "x.vts"});
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("SCENE.json"), HasSubstr("1e999")));
}

TEST_F(HostileInput, NothingFromAFileReachesTheTerminalRaw) {
  const std::string escaped = nlohmann::json(kEscape).dump();
  write_store("{\"created_by\":" + escaped + "}", "{\"no_data_class\":255,\"components\":[" + escaped + "],\"unit\":" + escaped +
                                                      ",\"classes\":[{\"id\":1,\"name\":" + escaped + "}],\"quality\":[{\"name\":" +
                                                      escaped + ",\"unit\":" + escaped + ",\"levels\":[{\"level\":0,\"max\":1}]}]}");
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"info", "s.vts"}, {"info", "s.vts", "--json"}, {"sample", "s.vts", "--texel", "1,1"}, {"validate", "s.vts"}}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_plain(outcome);
  }
  EXPECT_THAT(run({"info", "s.vts"}).out, HasSubstr("\\u001b]0;owned\\u0007\\u009b31m\\u202e\\u007f"));
  EXPECT_EQ(run_json("vtinspect-info", {"info", "s.vts"})["metadata"]["created_by"], kEscape) << "JSON spells it out and means it";

  // Names of files, and arguments.
  const std::string name = "a" + std::string(kEscape) + "\xff.vts";
  std::filesystem::copy(directory_ / "s.vts", directory_ / name);
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{{"info", name},
                                                                                       {"info", name, "--json"},
                                                                                       {"info", "none" + name},
                                                                                       {"validate", name},
                                                                                       {"extract", name, "-o", "b" + name},
                                                                                       {name}})
    expect_plain(run(command));
  expect_plain(build({"layer", name, "-o", "x.vts", "--channel", "color", "--crs", "pixel"}));
  expect_plain(build({"dataset", name, "-o", "x.vts"}));
}

TEST_F(HostileInput, NamesThatSteerTerminalsAreRefusedWhenALayerIsMade) {
  pipeline::write_raster(directory_ / "in.tif", {.width = 20, .height = 20}, [](auto, auto, int) { return 1.0; });
  for (const char* name : {"a\x1b[31m", "a\x7f", "a\xc2\x9b", "a\xe2\x80\xae", "a\nb", "a\xff", ""}) {
    if (*name == 0) continue;
    const Outcome outcome = build({"layer", "in.tif", "-o", "x.vts", "--channel", "color", "--name", name, "--progress", "none"});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    expect_plain(outcome);
  }
  EXPECT_EQ(build({"layer", "in.tif", "-o", "y.vts", "--channel", "color", "--name", "Größe α", "--progress", "none"}).exit_code, 0);
}

TEST_F(HostileInput, NamesThatAreNotUtf8AreTheUsersErrorWhereTheyWouldBeKept) {
  const std::string name = "bad\xff.tif";
  std::filesystem::create_directory(directory_ / "folder");
  pipeline::write_raster(directory_ / name, {.width = 20, .height = 20}, [](auto, auto, int) { return 1.0; });
  std::filesystem::copy(directory_ / name, directory_ / "folder" / name);
  for (const std::string& input : {name, std::string("folder")}) {
    const Outcome outcome = build({"layer", input, "-o", "x.vts", "--channel", "color"});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("bad\\xff.tif"), HasSubstr("not UTF-8")));
  }
  EXPECT_FALSE(std::filesystem::exists(directory_ / "x.vts"));
}

TEST_F(HostileInput, TooLittleMemoryIsSaidAndNotOurFault) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || __has_feature(address_sanitizer)
  GTEST_SKIP() << "a sanitizer takes more address space than this leaves";
#endif
  {
    auto writer = store::StoreWriter::create(directory_ / "wide.vts", {.area = {0.0, 0.0, 1.0, 1.0}}, {.sync = false});
    ASSERT_TRUE(writer);
    LayerInfo layer{.name = "light", .channel = ChannelType::kIllumination, .format = TexelFormat::kRgba32Float};
    layer.tile_exponent = 12;
    layer.data = {0, 0, 4096, 4096};
    layer.grid = {.origin_x = 0.0, .origin_y = 1.0, .step_x = 0x1p-12, .step_y = 0x1p-12};
    ASSERT_TRUE(writer->add_layer(layer));
    ASSERT_TRUE(writer->finish());
  }
  // A tile of it has 256 MiB, and two are needed; the program with its libraries takes less than 200.
  const Outcome outcome = run_program(
      "/bin/sh", {"-c", "ulimit -v 400000; exec \"$0\" \"$@\"", VT_VTINSPECT, "extract", "wide.vts", "--window", "0,0,1,1", "-o", "x.tif"},
      directory_.path());
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("not enough memory"));
  EXPECT_FALSE(std::filesystem::exists(directory_ / "x.tif"));
}

TEST_F(HostileInput, APipeIsNoStore) {
  ASSERT_EQ(::mkfifo((directory_ / "f.vts").c_str(), 0600), 0);
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"info", "f.vts"}, {"validate", "f.vts"}, {"extract", "f.vts", "-o", "x.tif"}, {"compare", "f.vts", "f.vts"}}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("f.vts: not a regular file"));
  }
  EXPECT_EQ(build({"update", "f.vts"}).exit_code, 2);
  std::filesystem::create_symlink("/dev/zero", directory_ / "zero.vts");
  EXPECT_THAT(run({"info", "zero.vts"}).err, HasSubstr("zero.vts: not a regular file"));
}

TEST_F(HostileInput, AStoreThatClaimsTheWholeEarthIsAnsweredAtOnce) {
  write_huge_store();
  for (const char* out : {"x.tif", "x.png"}) {
    const Outcome outcome = run({"extract", "huge.vts", "-o", out});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("2147483648 x 2147483648 texels"), HasSubstr("12.0 EiB"), HasSubstr("--window"),
                                   HasSubstr("--level 5 (8192 x 8192 texels, 192.0 MiB)")));
  }
  EXPECT_EQ(run({"extract", "huge.vts", "--window", "5,6,70,80", "-o", "x.png"}).exit_code, 0);
  EXPECT_EQ(run({"extract", "huge.vts", "--level", "6", "--window", "5,6,70,80", "-o", "x.png"}).exit_code, 0);
  std::filesystem::copy(directory_ / "huge.vts", directory_ / "other.vts");
  const auto json = run_json("vtinspect-compare", {"compare", "huge.vts", "other.vts"});
  EXPECT_EQ(json["equal"], true);
  EXPECT_EQ(json["layers"][0]["levels"].size(), 24U);
  EXPECT_EQ(run({"info", "huge.vts"}).exit_code, 0);
}

// Long work, stopped as soon as it says that it has begun: nothing of it stays.
TEST_F(HostileInput, CtrlCStopsAnExtractionAndLeavesNothing) {
  write_huge_store();
  std::array<int, 2> err{};
  ASSERT_EQ(::pipe(err.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::chdir(directory_.path().c_str()) != 0 || ::dup2(err[1], STDERR_FILENO) < 0) ::_exit(126);
    ::close(err[0]);
    ::execl(VT_VTINSPECT, VT_VTINSPECT, "extract", "huge.vts", "--window", "0,0,262144,2097152", "-o", "x.tif", "--progress", "plain",
            nullptr);
    ::_exit(127);
  }
  ::close(err[1]);
  std::string said;
  std::array<char, 256> piece{};
  while (said.find("extracting: ") == std::string::npos) {
    const ssize_t got = ::read(err[0], piece.data(), piece.size());
    ASSERT_GT(got, 0) << "it ended by itself: " << said;
    said.append(piece.data(), static_cast<std::size_t>(got));
  }
  ASSERT_EQ(::kill(child, SIGINT), 0);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ::close(err[0]);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(files(), std::vector<std::string>{"huge.vts"});
}

}  // namespace
}  // namespace vt::test
