// The program is killed at random moments, again and again, and started again with the same command.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// Runs `work` in a process of its own; kills it after `milliseconds` unless it has ended. Returns whether it
// ended by itself, with success.
template <class Work>
bool run_and_kill(const Work& work, std::optional<double> milliseconds) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  if (milliseconds) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(*milliseconds));
    kill(child, SIGKILL);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0) << "the build failed by itself";
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// The same build twice over: through the library, which starts in no time, so that many moments can be tried,
// and as the program that people run.
int build_with_library(const std::filesystem::path& input, const std::filesystem::path& store, int threads, bool update = false) {
  LayerRequest request = request_for({input}, ChannelType::kColor);
  auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  if (!plan) return 1;
  auto writer = open_or_create(store, plan->crs, plan->extent());
  if (!writer) return 2;
  if (!build_layer(*writer, *plan, {.threads = threads, .block_levels = 1, .checkpoint_seconds = 0.002, .update = update})) return 3;
  return writer->finish() ? 0 : 4;
}

int build_with_program(const std::filesystem::path& input, const std::filesystem::path& store, int threads) {
  const std::string count = std::to_string(threads);
  if (freopen("/dev/null", "w", stdout) == nullptr) return 126;
  execl(VT_VTBUILD, "vtbuild", "layer", input.c_str(), "-o", store.c_str(), "--channel", "color", "--tile", "32", "--block", "1",
        "--threads", count.c_str(), "--checkpoint", "0.01", "--progress", "none", nullptr);
  return 127;
}

class Kill : public testing::Test {
 protected:
  void SetUp() override {
    write_raster(folder_ / "input.tif", {.width = 500, .height = 400, .nodata = 3.0}, [](std::int64_t x, std::int64_t y, int band) {
      return (x / 50 + y / 70) % 5 == 0 ? 3.0 : static_cast<double>(hash_noise(x, y, band) % 200) + 20;
    });
    ASSERT_EQ(build_with_library(folder_ / "input.tif", folder_ / "whole.vts", 1), 0);
    wanted_ = tiles_of(folder_ / "whole.vts", "color");
    ASSERT_FALSE(wanted_.empty());
  }

  template <class Build>
  void survive(const Build& build_store, int kills_wanted) {
    const auto work = [&](const std::filesystem::path& store, int threads) {
      return [&, store, threads] { return build_store(folder_ / "input.tif", store, threads); };
    };
    const auto start = std::chrono::steady_clock::now();
    ASSERT_TRUE(run_and_kill(work(folder_ / "timed.vts", 1), std::nullopt));
    const double whole_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    std::mt19937 random(20);
    // From before the work has begun to just before its end.
    std::uniform_real_distribution<double> moment(0.0, whole_ms);
    int kills = 0;
    int stores = 0;
    while (kills < kills_wanted) {
      const auto path = folder_ / ("killed" + std::to_string(stores++) + ".vts");
      const int threads = 1 + stores % 4;
      // At most twelve kills for one store, so that it also gets finished.
      for (int i = 0; i < 12 && kills < kills_wanted; ++i) {
        if (run_and_kill(work(path, threads), moment(random))) break;
        ++kills;
        if (!std::filesystem::exists(path)) continue;
        const auto report = store::validate(path);
        ASSERT_TRUE(report.has_value());
        ASSERT_TRUE(report->ok()) << report->findings.front().place << ": " << report->findings.front().sentence;
      }
      ASSERT_TRUE(run_and_kill(work(path, threads), std::nullopt));
      ASSERT_TRUE(tiles_of(path, "color") == wanted_) << "after " << kills << " kills";
      std::filesystem::remove(path);
    }
  }

  test::TempFolder folder_;
  Tiles wanted_;
};

TEST_F(Kill, AnyMomentIsSurvivedAndTheResultIsTheSame) {
  survive([](const auto& input, const auto& store, int threads) { return build_with_library(input, store, threads); }, 200);
}
TEST_F(Kill, TheProgramGoesOnWithTheSameCommand) { survive(build_with_program, 12); }

// The sources of a finished store have changed; the update is killed again and again.
TEST_F(Kill, AnUpdateGoesOnToo) {
  const auto half_changed = [](std::int64_t x, std::int64_t y, int band) {
    return (x / 50 + y / 70) % 5 == 0 ? 3.0 : static_cast<double>(hash_noise(x, y, y > 150 ? band + 7 : band) % 200) + 20;
  };
  write_raster(folder_ / "changed.tif", {.width = 500, .height = 400, .nodata = 3.0}, half_changed);
  ASSERT_EQ(build_with_library(folder_ / "changed.tif", folder_ / "changed.vts", 1), 0);
  const Tiles changed = tiles_of(folder_ / "changed.vts", "color");
  ASSERT_FALSE(changed == wanted_);
  const auto update = [&](const std::filesystem::path& input, const std::filesystem::path& store, int threads) {
    // Begins as a copy of the finished store of the raster as it was.
    if (!std::filesystem::exists(store)) {
      const std::filesystem::path copy = store.string() + ".copy";
      std::filesystem::copy_file(folder_ / "whole.vts", copy, std::filesystem::copy_options::overwrite_existing);
      std::filesystem::rename(copy, store);
    }
    return build_with_library(input, store, threads, true);
  };
  std::filesystem::rename(folder_ / "changed.tif", folder_ / "input.tif");
  wanted_ = changed;
  survive(update, 60);
}

// Ctrl-C: the program says how to go on, ends by itself with the shell's exit code for it, and keeps what was
// done. It is stopped once its layer is in the store: from then on it listens. When it is faster than this
// test, it is tried again.
TEST_F(Kill, AnInterruptedProgramSaysHowToGoOn) {
  const auto path = folder_ / "interrupted.vts";
  const auto has_begun = [&] {
    const auto reader = store::StoreReader::open(path);
    return reader && !reader->layers().empty();
  };
  for (int interrupted = 0; interrupted < 5;) {
    std::filesystem::remove(path);
    const auto messages = folder_ / "messages.txt";
    const pid_t child = fork();
    if (child == 0) {
      if (freopen(messages.c_str(), "w", stderr) == nullptr) _exit(126);
      _exit(build_with_program(folder_ / "input.tif", path, 1));
    }
    int status = 0;
    bool is_over = false;
    while (!is_over && !has_begun()) is_over = waitpid(child, &status, WNOHANG) == child;
    if (!is_over) {
      kill(child, SIGINT);
      ASSERT_EQ(waitpid(child, &status, 0), child);
    }
    ASSERT_TRUE(WIFEXITED(status)) << "it was killed by the signal";
    if (WEXITSTATUS(status) == 0) continue;
    ++interrupted;
    EXPECT_EQ(WEXITSTATUS(status), 130);
    std::ifstream file(messages);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(text.find("run the same command again to go on"), std::string::npos) << text;
    ASSERT_TRUE(store::validate(path)->ok());
    ASSERT_EQ(build_with_library(folder_ / "input.tif", path, 2), 0);
    ASSERT_TRUE(tiles_of(path, "color") == wanted_);
  }
}

}  // namespace
}  // namespace vt::pipeline
