// The same bytes whatever the machine, its processors, the memory it is given, and however often it is interrupted.
#include <gtest/gtest.h>

#include "tests/pipeline/layer_kinds.h"
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

// Stopped once at some part of the work, then finished by another number of threads.
TEST(Determinism, ThreadsBlocksMemoryAndInterruptionsDoNotShow) {
  const test::TempFolder folder;
  for (const Case& c : cases()) {
    const LayerRequest request = request_of(c, reference().input(c));
    for (const int threads : {1, 2, 3})
      for (const int block_levels : {1, 2, 3})
        for (const int stop_percent : {5, 40, 75}) {
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
            // Of many blocks some are left when the first is done; a layer of one block or two may be done before it notices.
            if (block_levels == 1 && stop_percent == 5) {
              ASSERT_FALSE(stopped.has_value()) << c.name;
            }
          }
          build(path, request, {.threads = 4 - threads, .memory_bytes = std::size_t{256} << 20});
          ASSERT_TRUE(textures_of(path) == reference().textures(c))
              << c.name << ", " << threads << " threads, block " << block_levels << ", stopped at " << stop_percent << " %";
        }
  }
}

}  // namespace
}  // namespace vt::pipeline
