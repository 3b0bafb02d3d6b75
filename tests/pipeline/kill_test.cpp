// The program is killed at random moments, again and again, and started again with the same command.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <thread>

#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// Runs vtbuild; kills it after `milliseconds` unless it has ended. Returns whether it ended by itself, with success.
bool run_vtbuild(const std::vector<std::string>& arguments, std::optional<double> milliseconds) {
  const pid_t child = fork();
  if (child == 0) {
    std::vector<char*> argv;
    std::string program = VT_VTBUILD;
    argv.push_back(program.data());
    std::vector<std::string> copy = arguments;
    for (std::string& argument : copy) argv.push_back(argument.data());
    argv.push_back(nullptr);
    freopen("/dev/null", "w", stdout);
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  if (milliseconds) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(*milliseconds));
    kill(child, SIGKILL);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0) << "vtbuild failed by itself";
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(Kill, AnyMomentIsSurvivedAndTheResultIsTheSame) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 500, .height = 400, .nodata = 3.0}, [](std::int64_t x, std::int64_t y, int band) {
    return (x / 50 + y / 70) % 5 == 0 ? 3.0 : static_cast<double>(hash_noise(x, y, band) % 200) + 20;
  });
  const auto arguments = [&](const std::filesystem::path& store, int threads) {
    return std::vector<std::string>{"layer",     (folder / "input.tif").string(), "-o",           store.string(), "--channel",  "color",
                                    "--tile",    "64",                            "--block",      "1",            "--threads",  std::to_string(threads),
                                    "--checkpoint", "0.01",                       "--progress",   "none"};
  };
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(run_vtbuild(arguments(folder / "whole.vts", 1), std::nullopt));
  const double whole_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  const Tiles wanted = tiles_of(folder / "whole.vts", "color");
  ASSERT_FALSE(wanted.empty());

  std::mt19937 random(20);
  // From before the program has begun to just before its end.
  std::uniform_real_distribution<double> moment(0.0, whole_ms);
  constexpr int kKills = 200;
  int kills = 0;
  int stores = 0;
  while (kills < kKills) {
    const auto path = folder / ("killed" + std::to_string(stores++) + ".vts");
    const int threads = 1 + stores % 4;
    // At most twelve kills for one store, so that it also gets finished.
    for (int i = 0; i < 12 && kills < kKills; ++i) {
      if (run_vtbuild(arguments(path, threads), moment(random))) break;
      ++kills;
      if (!std::filesystem::exists(path)) continue;
      const auto report = store::validate(path);
      ASSERT_TRUE(report.has_value());
      ASSERT_TRUE(report->ok()) << report->findings.front().place << ": " << report->findings.front().sentence;
    }
    ASSERT_TRUE(run_vtbuild(arguments(path, threads), std::nullopt));
    ASSERT_TRUE(tiles_of(path, "color") == wanted) << "after " << kills << " kills";
    std::filesystem::remove(path);
  }
}

}  // namespace
}  // namespace vt::pipeline
