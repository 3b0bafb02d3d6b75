#include "builder/pipeline/layer_build.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "builder/pipeline/block_job.h"
#include "builder/pipeline/plan_cost.h"

namespace vt::pipeline {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// The layers of a plan in the store: found from an earlier run, or added.
struct OpenLayers {
  LayerIds ids;
  bool is_complete = false;
  int block_levels = 0;
};

std::string carry_name(const std::string& layer) { return layer + "/carry"; }

Result<OpenLayers> open_layers(store::StoreWriter& writer, const LayerPlan& plan, int block_levels) {
  OpenLayers layers;
  if (const auto existing = writer.find_layer(plan.info.name)) {
    const auto metadata = nlohmann::ordered_json::parse(existing->metadata_json, nullptr, false);
    if (!metadata.is_object() || !metadata.contains("settings") || metadata["settings"] != plan.settings ||
        !metadata.contains("block_levels") || !metadata["block_levels"].is_number_integer())
      return fail(ErrorCode::kExists, "the store already has a layer '" + plan.info.name +
                                          "' that was built from other sources or settings; choose another --name or another store");
    layers.ids.texture = existing->id;
    layers.is_complete = existing->state == LayerState::kComplete;
    layers.block_levels = metadata["block_levels"].get<int>();
    if (layers.block_levels < 1 || layers.block_levels > kMaxTileExponent)
      return fail(ErrorCode::kInvalidData, "layer '" + plan.info.name + "': its metadata say block_levels " +
                                               std::to_string(layers.block_levels) + ", 1 to 12 are possible");
    const auto carry = writer.find_layer(carry_name(plan.info.name));
    const bool needs_carry = !layers.is_complete && plan.info.finest.value >= layers.block_levels;
    if (needs_carry && (!carry || carry->role != LayerRole::kCarry || carry->owner != layers.ids.texture))
      return fail(ErrorCode::kInvalidData, "layer '" + plan.info.name + "' is unfinished and its carry layer '" +
                                               carry_name(plan.info.name) +
                                               "' is not in the store, so its build cannot go on; choose another --name or another store");
    if (carry) layers.ids.carry = carry->id;
    return layers;
  }

  layers.block_levels = block_levels;
  LayerInfo info = plan.info;
  nlohmann::ordered_json metadata;
  metadata["settings"] = plan.settings;
  metadata["block_levels"] = block_levels;
  info.metadata_json = metadata.dump();
  VT_ASSIGN(layers.ids.texture, writer.add_layer(info));
  if (info.finest.value >= block_levels) {
    LayerInfo carry = plan.info;
    carry.name = carry_name(plan.info.name);
    carry.role = LayerRole::kCarry;
    carry.owner = layers.ids.texture;
    carry.format = plan.sampler->codec().carry_format();
    carry.transfer = Transfer::kLinear;
    carry.metadata_json = "{}";
    VT_ASSIGN(layers.ids.carry, writer.add_layer(carry));
  }
  // From here on the same command finds its layers again.
  VT_CHECK(writer.commit());
  return layers;
}

// Runs the blocks of one tier on all workers. Stops at the first error.
class TierRun {
 public:
  TierRun(const LayerPlan& plan, LayerIds ids, const Tier& tier, bool first_tier, store::StoreWriter& writer, const BuildOptions& options,
          std::atomic<std::uint64_t>& done_texels, std::uint64_t total_texels)
      : plan_(plan),
        ids_(ids),
        tier_(tier),
        first_tier_(first_tier),
        writer_(writer),
        options_(options),
        done_texels_(done_texels),
        total_(total_texels) {}

  // Commits every checkpoint_seconds while the workers run.
  [[nodiscard]] Result<void> run(int threads) {
    const auto workers_wanted = static_cast<int>(std::min<std::int64_t>(threads, tier_.blocks()));
    running_ = workers_wanted;
    std::vector<std::jthread> workers;
    for (int i = 0; i < workers_wanted; ++i) workers.emplace_back([this] { work(); });
    std::unique_lock lock(mutex_);
    const auto interval = std::chrono::duration<double>(options_.checkpoint_seconds);
    while (!finished_.wait_for(lock, interval, [this] { return running_ == 0; })) {
      lock.unlock();
      auto committed = writer_.commit();
      lock.lock();
      if (!committed) stop_with(committed.error());
    }
    workers.clear();
    if (error_) return tl::unexpected(*error_);
    return {};
  }

  std::atomic<std::int64_t> built{0};
  std::atomic<std::int64_t> resumed{0};

 private:
  void work() {
    BlockJob job(plan_, ids_, writer_);
    const auto report = [this](std::uint64_t texels) {
      const std::uint64_t done = done_texels_.fetch_add(texels, std::memory_order_relaxed) + texels;
      if (options_.progress) options_.progress(done, total_);
    };
    for (std::int64_t index = next_++; index < tier_.blocks() && !stopped_; index = next_++) {
      if (tier_.has_carry && writer_.contains(ids_.carry, tier_.carry_tile(index))) {
        ++resumed;
        const TexelRect part = intersect(tier_.block(index), tier_.data);
        if (first_tier_) report(static_cast<std::uint64_t>(part.width * part.height));
        continue;
      }
      auto result = run_block(job, index, report);
      if (!result) {
        const std::lock_guard lock(mutex_);
        stop_with(result.error());
        break;
      }
      ++built;
    }
    const std::lock_guard lock(mutex_);
    if (--running_ == 0) finished_.notify_all();
  }

  // An exception (out of memory) ends the build, not the process.
  [[nodiscard]] Result<void> run_block(BlockJob& job, std::int64_t index, const std::function<void(std::uint64_t)>& report) {
    try {
      return job.run(tier_, first_tier_, index, report, options_.cancel);
    } catch (const std::exception& problem) {
      return fail(ErrorCode::kInternal, "layer '" + plan_.info.name + "', level " + std::to_string(tier_.base.value) + ", block " +
                                            std::to_string(index) + ": " + problem.what());
    }
  }

  void stop_with(const Error& error) {  // under mutex_
    if (!error_) error_ = error;
    stopped_ = true;
  }

  const LayerPlan& plan_;
  LayerIds ids_;
  const Tier& tier_;
  bool first_tier_;
  store::StoreWriter& writer_;
  const BuildOptions& options_;
  std::atomic<std::uint64_t>& done_texels_;
  std::uint64_t total_;
  std::atomic<std::int64_t> next_{0};
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable finished_;
  int running_ = 0;             // under mutex_
  std::optional<Error> error_;  // under mutex_
};

}  // namespace

Result<BuildReport> build_layer(store::StoreWriter& writer, const LayerPlan& plan, const BuildOptions& options) {
  const auto start = Clock::now();
  const int threads = options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  int block_levels = options.block_levels;
  if (block_levels == 0) {
    VT_ASSIGN(block_levels, choose_block_levels(plan, threads, options.memory_bytes));
  }

  VT_ASSIGN(const OpenLayers layers, open_layers(writer, plan, block_levels));
  BuildReport report;
  report.block_levels = layers.block_levels;
  report.base_texels = static_cast<std::uint64_t>(plan.info.data.width) * static_cast<std::uint64_t>(plan.info.data.height);
  report.was_complete = layers.is_complete;

  if (!layers.is_complete) {
    std::atomic<std::uint64_t> done_texels{0};
    const std::vector<Tier> tiers = plan_tiers(plan.info, layers.block_levels);
    for (std::size_t i = 0; i < tiers.size(); ++i) {
      TierRun tier(plan, layers.ids, tiers[i], i == 0, writer, options, done_texels, report.base_texels);
      auto result = tier.run(threads);
      report.blocks_built += tier.built;
      report.blocks_resumed += tier.resumed;
      if (!result) {
        // What is done is kept, whatever stopped the rest. If it was the store itself, it refuses, and the first error is the one to tell.
        [[maybe_unused]] const auto kept = writer.commit();
        return tl::unexpected(std::move(result).error());
      }
    }
    VT_CHECK(writer.set_state(layers.ids.texture, LayerState::kComplete));
    if (plan.info.finest.value >= layers.block_levels) VT_CHECK(writer.set_state(layers.ids.carry, LayerState::kComplete));
    VT_CHECK(writer.commit());
  }

  const auto info = writer.find_layer(plan.info.name);
  report.tiles = info->tiles;
  report.constant_tiles = info->constant_tiles;
  report.stored_bytes = info->stored_bytes;
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace vt::pipeline
