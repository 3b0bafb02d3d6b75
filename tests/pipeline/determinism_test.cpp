// The same bytes whatever the machine, its processors, the memory it is given, and however often it is
// interrupted.
#include <gtest/gtest.h>

#include <array>

#include "tests/pipeline/layers/layer_kinds.h"
#include "tests/support/cpu_targets.h"

namespace vt::pipeline {
namespace {

// The tiles of every texture in a store: the layer and the parts beside it.
std::map<std::string, Tiles> textures_of(const std::filesystem::path& store_path) {
  std::map<std::string, Tiles> textures;
  auto reader = store::StoreReader::open(store_path);
  EXPECT_TRUE(reader.has_value()) << reader.error().message;
  for (const LayerInfo& layer : reader->layers())
    if (layer.role == LayerRole::kTexture) textures[layer.name] = tiles_of(store_path, layer.name);
  return textures;
}

class WholeBuild : public test::OnEveryCpuTarget {};

// The reference is built by the best vector unit that this processor has, before the test's own is forced.
class Reference {
 public:
  Reference() {
    for (const Case& c : cases()) {
      write_raster(folder_ / (c.name + ".tif"), c.raster, c.value);
      build(folder_ / (c.name + ".vts"), request_of(c, input(c)), {.threads = 1});
      tiles_[c.name] = textures_of(folder_ / (c.name + ".vts"));
    }
  }
  [[nodiscard]] std::filesystem::path input(const Case& c) const { return folder_ / (c.name + ".tif"); }
  [[nodiscard]] const std::map<std::string, Tiles>& textures(const Case& c) const { return tiles_.at(c.name); }

 private:
  test::TempFolder folder_;
  std::map<std::string, std::map<std::string, Tiles>> tiles_;
};

const Reference& reference() {
  static const Reference made;
  return made;
}

TEST_P(WholeBuild, GivesTheSameTilesOnEveryCpu) {
  const test::TempFolder folder;
  for (const Case& c : cases()) {
    const LayerRequest request = request_of(c, reference().input(c));
    build(folder / (c.name + ".vts"), request, {.threads = 2, .block_levels = 2});
    EXPECT_TRUE(textures_of(folder / (c.name + ".vts")) == reference().textures(c)) << c.name;
  }
}

VT_ON_EVERY_CPU_TARGET(WholeBuild);

// Stopped once at some part of the work, then finished by another number of threads. Every number of threads
// with every size of block, and every part of the work with each of them: a Latin square, which begins
// elsewhere with every kind of layer.
class Interrupted : public testing::TestWithParam<std::size_t> {};

TEST_P(Interrupted, BuildsGiveTheSameTilesWhateverTheThreadsBlocksAndMemory) {
  const Case c = cases()[GetParam()];
  const test::TempFolder folder;
  write_raster(folder / "input.tif", c.raster, c.value);
  const LayerRequest request = request_of(c, folder / "input.tif");
  build(folder / "whole.vts", request, {.threads = 1});
  const std::map<std::string, Tiles> wanted = textures_of(folder / "whole.vts");
  for (const int threads : {1, 2, 3})
    for (const int block_levels : {1, 2, 3}) {
      const int stop_percent = std::array{5, 40, 75}[(GetParam() + static_cast<std::size_t>(threads + block_levels)) % 3];
      const auto path = folder / "stopped.vts";
      std::filesystem::remove(path);
      const auto plan = plan_layer(request, std::nullopt, std::size_t{1} << 20);
      ASSERT_TRUE(plan.has_value()) << plan.error().message;
      std::atomic<bool> cancel{false};
      BuildOptions options{.threads = threads, .block_levels = block_levels, .cancel = &cancel};
      options.progress = [&](std::uint64_t done, std::uint64_t total) {
        cancel = cancel || done * 100 >= total * static_cast<std::uint64_t>(stop_percent);
      };
      {
        auto writer = open_or_create(path, plan->crs, plan->extent());
        ASSERT_TRUE(writer.has_value());
        const auto stopped = build_layer(*writer, *plan, options);
        ASSERT_TRUE(stopped.has_value() || stopped.error().code == ErrorCode::kCancelled) << stopped.error().message;
        // Some of many blocks are left when the first is done; a layer of one block or two may be done before
        // it notices.
        if (block_levels == 1 && stop_percent == 5) {
          ASSERT_FALSE(stopped.has_value());
        }
      }
      build(path, request, {.threads = 4 - threads, .memory_bytes = std::size_t{256} << 20});
      ASSERT_TRUE(textures_of(path) == wanted) << threads << " threads, block " << block_levels << ", stopped at " << stop_percent << " %";
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Interrupted, testing::Range<std::size_t>(0, cases().size()),
                         [](const auto& number) { return cases()[number.param].name; });

}  // namespace
}  // namespace vt::pipeline
