// --memory is what the whole program may use: measured as the peak resident set of vtbuild, libraries
// included.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "builder/pipeline/build/build_memory.h"
#include "tests/pipeline/big_tiff.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMeasurable = false;
#else
constexpr bool kMeasurable = true;
#endif

// In a process of its own: a program that is started from this one is charged with what this one has used
// before.
void in_child(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

struct Outcome {
  int exit_code = -1;
  std::size_t peak_bytes = 0;
};

Outcome run_vtbuild(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), VT_VTBUILD);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (freopen("/dev/null", "w", stdout) == nullptr || freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
    execv(VT_VTBUILD, words.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  EXPECT_EQ(wait4(child, &status, 0, &usage), child);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, static_cast<std::size_t>(usage.ru_maxrss) * 1024};
}

class Memory : public testing::Test {
 protected:
  void SetUp() override {
    if (!kMeasurable) GTEST_SKIP() << "a sanitizer's own memory is not ours to count";
  }

  // Builds with each amount of memory and number of threads.
  void expect_within(const std::string& input, const std::vector<std::string>& options,
                     const std::vector<std::pair<int, int>>& mebibytes_threads) {
    for (const auto& [mebibytes, threads] : mebibytes_threads) {
      const auto store = folder_ / "out.vts";
      std::filesystem::remove(store);
      std::vector<std::string> arguments{
          "layer",    (folder_ / input).string(),      "-o",        store.string(),         "--progress", "none",
          "--memory", std::to_string(mebibytes) + "M", "--threads", std::to_string(threads)};
      arguments.insert(arguments.end(), options.begin(), options.end());
      const Outcome run = run_vtbuild(arguments);
      EXPECT_EQ(run.exit_code, 0) << input << " with " << mebibytes << "M and " << threads << " threads";
      EXPECT_LE(run.peak_bytes, static_cast<std::size_t>(mebibytes) << 20) << input << " with " << threads << " threads";
    }
  }

  test::TempFolder folder_;
};

double code(std::int64_t x, std::int64_t y, int band) { return (x / 40 + y / 56) % 100 + hash_noise(x, y, band) % 100; }

TEST_F(Memory, APlainRasterBuildsInWhatItIsGiven) {
  in_child([&] { write_raster(folder_ / "plain.tif", {.width = 3000, .height = 3000, .tile = 256}, code); });
  expect_within("plain.tif", {"--channel", "color"}, {{40, 1}, {104, 4}, {512, 2}});
}

TEST_F(Memory, SoDoesAResampledOne) {
  in_child([&] { write_raster(folder_ / "plain.tif", {.width = 2000, .height = 2000, .tile = 256}, code); });
  expect_within("plain.tif", {"--channel", "color", "--gsd", "1.3"}, {{48, 1}, {120, 4}});
  expect_within("plain.tif", {"--channel", "color", "--crs", "EPSG:4326"}, {{48, 1}, {120, 4}});
}

TEST_F(Memory, SoDoesOneOfLargeCompressedTiles) {
  in_child([&] {
    write_raster(folder_ / "large.tif",
                 {.width = 4000, .height = 2048, .tile = 1024, .compression = source::GeoTiffSpec::Compression::kDeflate}, code);
  });
  expect_within("large.tif", {"--channel", "color"}, {{60, 1}, {144, 4}});
}

TEST_F(Memory, SoDoesAMosaic) {
  in_child([&] {
    std::filesystem::create_directory(folder_ / "tiles");
    for (std::int64_t i = 0; i < 400; ++i) {
      RasterSpec spec{
          .width = 100, .height = 100, .bands = 1, .type = SampleType::kFloat32, .compression = source::GeoTiffSpec::Compression::kLzw};
      spec.transform.x0 += static_cast<double>(i % 20 * 100) * spec.transform.x_column;
      spec.transform.y0 += static_cast<double>(i / 20 * 100) * spec.transform.y_row;
      write_raster(folder_ / ("tiles/" + std::to_string(i) + ".tif"), spec, code);
    }
  });
  expect_within("tiles", {"--channel", "elevation"}, {{56, 1}, {104, 4}});
}

// Twelve parts and 49 planes, of which one copy is kept to be compared with all parts.
TEST_F(Memory, SoDoHorizonsInAllDirections) {
  in_child([&] {
    write_raster(folder_ / "horizons.tif", {.width = 1100, .height = 1100, .bands = 24, .type = SampleType::kFloat32, .tile = 128},
                 [](std::int64_t x, std::int64_t y, int band) { return (hash_noise(x, y, band) % 1000) / 1000.0 - 0.2; });
  });
  expect_within("horizons.tif", {"--channel", "horizon", "--tile", "128"}, {{112, 1}, {190, 2}});
}

TEST_F(Memory, SoDoClassesWithTheirMixture) {
  in_child([&] {
    write_raster(
        folder_ / "classes.tif", {.width = 2500, .height = 2500, .bands = 1, .tile = 256},
        [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(1 + (x / 40 + y / 56) % 12 + hash_noise(x, y, 0) % 4); });
  });
  expect_within("classes.tif", {"--channel", "material", "--mixture", "4"}, {{72, 1}, {232, 4}});
}

TEST_F(Memory, SoDoHeightsWhoseSurfacesAreMeasured) {
  in_child([&] {
    write_raster(folder_ / "heights.tif", {.width = 3000, .height = 3000, .bands = 1, .type = SampleType::kFloat32, .tile = 256}, code);
  });
  expect_within("heights.tif", {"--channel", "elevation", "--surface-error", "yes", "--tile", "1024", "--compression", "none"},
                {{120, 1}, {220, 2}});
}

// The plan of a file of 1,125,000 x 875,000 samples does not read its tables of 240 MB.
TEST_F(Memory, PlanningTheLargestFilesTakesNextToNothing) {
  write_unwritten_tiff(folder_ / "huge.tif", 1'125'000, 875'000, 3, false, 100000.0, 5700000.0, 0.8);
  const Outcome run =
      run_vtbuild({"layer", (folder_ / "huge.tif").string(), "-o", (folder_ / "x.vts").string(), "--channel", "color", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_LE(run.peak_bytes, std::size_t{32} << 20);
}

TEST(BuildMemory, AsManyThreadsMeasureTheSurfaceAsFit) {
  const BuildMemory memory{.program = 10, .sources = 6, .store = 4, .worker = 5, .surface = 30};
  EXPECT_EQ(memory.total(4), 50U) << "one thread at least";
  EXPECT_EQ(memory.total(8), 60U) << "workers are done before";
  EXPECT_EQ(memory.surface_threads(4, 109), 2);
  EXPECT_EQ(memory.surface_threads(4, 110), 3);
  EXPECT_EQ(memory.surface_threads(2, 1000), 2);
  EXPECT_EQ(memory.surface_threads(4, 10), 1);
}

TEST_F(Memory, WhatCannotFitSaysWhatWould) {
  write_raster(folder_ / "a.tif", {.width = 600, .height = 600}, code);
  const auto plan = plan_layer(request_for({folder_ / "a.tif"}, ChannelType::kColor), std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value());
  const auto refused = choose_block_levels(*plan, 64, std::size_t{40} << 20);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);

  // The memory that it asks for is enough, and so is the number of threads that it offers.
  const std::string& message = refused.error().message;
  const auto number_after = [&](const std::string& words) {
    const std::size_t at = message.find(words);
    EXPECT_NE(at, std::string::npos) << message;
    return at == std::string::npos ? 0 : std::stoi(message.substr(at + words.size()));
  };
  const int mebibytes = number_after("it needs `memory` ");
  const int threads = number_after("or `threads` ");
  EXPECT_TRUE(choose_block_levels(*plan, 64, static_cast<std::size_t>(mebibytes) << 20).has_value());
  EXPECT_TRUE(choose_block_levels(*plan, threads, std::size_t{40} << 20).has_value());
  EXPECT_FALSE(choose_block_levels(*plan, threads + 1, std::size_t{40} << 20).has_value());
}

// With more memory the sources keep more: what a refusal names has to be enough for a plan that is made with
// it.
TEST_F(Memory, WhatARefusalNamesIsEnoughForAllLayers) {
  write_unwritten_tiff(folder_ / "large.tif", 60000, 40000, 3, false, 100000.0, 5700000.0, 0.8);
  write_unwritten_tiff(folder_ / "small.tif", 3000, 2000, 3, false, 100000.0, 5700000.0, 16.0);
  const auto plans_with = [&](std::size_t memory) {
    std::vector<LayerPlan> plans;
    for (const char* name : {"small.tif", "large.tif"}) {
      LayerRequest request = request_for({folder_ / name}, ChannelType::kColor);
      request.name = name;
      auto plan = plan_layer(request, std::nullopt, source_cache_bytes(memory));
      EXPECT_TRUE(plan) << plan.error().message;
      plans.push_back(std::move(*plan));
    }
    return plans;
  };
  for (const int threads : {1, 8, 64, 200}) {
    const std::size_t little = std::size_t{20} << 20;
    const auto refused = choose_block_levels(plans_with(little), threads, little);
    ASSERT_FALSE(refused) << threads;
    const std::string words = "it needs `memory` ";
    const std::size_t at = refused.error().message.find(words);
    ASSERT_NE(at, std::string::npos) << refused.error().message;
    const std::size_t named = std::stoul(refused.error().message.substr(at + words.size())) << 20;
    const auto chosen = choose_block_levels(plans_with(named), threads, named);
    EXPECT_TRUE(chosen) << refused.error().message << "; and then: " << chosen.error().message;
    EXPECT_FALSE(choose_block_levels(plans_with(named / 2), threads, named / 2)) << "and not far from what is needed";
  }
}

}  // namespace
}  // namespace vt::pipeline
