#include "builder/pipeline/build/layer_build.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "builder/pipeline/blocks/block_quality.h"
#include "builder/pipeline/blocks/built_layer.h"
#include "builder/pipeline/build/build_memory.h"
#include "builder/pipeline/build/source_check.h"
#include "builder/pipeline/parallel/parallel.h"
#include "builder/pipeline/passes/coverage_pass.h"
#include "builder/pipeline/passes/surface_pass.h"

namespace vt::pipeline {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Counts texels of work over all tiers.
struct WorkCounter {
  std::atomic<std::uint64_t> done{0};
  std::uint64_t total = 0;
  const std::function<void(std::uint64_t, std::uint64_t)>& report;

  void add(std::uint64_t texels) {
    const std::uint64_t now = done.fetch_add(texels, std::memory_order_relaxed) + texels;
    if (report) report(now, total);
  }
};

// Runs blocks of one tier on all workers. Stops at the first error.
class TierRun {
 public:
  TierRun(const LayerPlan& plan, const WorkMap& work, const LayerIds& ids, std::size_t tier, std::vector<std::int64_t> blocks,
          store::StoreWriter& writer, const BuildOptions& options, WorkCounter& counter)
      : plan_(plan),
        work_(work),
        ids_(ids),
        tier_(tier),
        blocks_(std::move(blocks)),
        writer_(writer),
        options_(options),
        counter_(counter) {}

  // Commits every checkpoint_seconds while the workers run. Adds what was done to `report`, also when it
  // fails.
  [[nodiscard]] Result<void> run(int threads, BuildReport& report) {
    const auto workers_wanted = std::min(static_cast<std::size_t>(threads), blocks_.size());
    running_ = workers_wanted;
    std::vector<std::jthread> workers;
    std::optional<std::string> refusal;
    try {
      while (workers.size() < workers_wanted) workers.emplace_back([this] { work(); });
    } catch (const std::system_error& problem) {
      refusal = problem.what();  // the threads that there are do the work
    }
    std::unique_lock lock(mutex_);
    running_ -= workers_wanted - workers.size();
    finished_.notify_all();
    if (workers.empty() && refusal) return fail(ErrorCode::kIo, "the system gives no thread to work with: " + *refusal);
    const auto interval = std::chrono::duration<double>(options_.checkpoint_seconds);
    while (!finished_.wait_for(lock, interval, [this] { return running_ == 0; })) {
      lock.unlock();
      const auto start = Clock::now();
      auto committed = writer_.commit();
      report.commit_seconds += seconds_since(start);
      lock.lock();
      if (!committed) stop_with(committed.error());
    }
    lock.unlock();
    workers.clear();
    report.blocks_built += built_;
    report.tile_counts += counts_;
    report.stages += stages_;
    if (error_) return tl::unexpected(*error_);
    return {};
  }

 private:
  void work() {
    BlockJob job(plan_, work_, ids_, writer_, options_.with_stats);
    const auto report = [this](std::uint64_t texels) { counter_.add(texels); };
    while (const auto index = take_block()) {
      auto result = run_block(job, *index, report);
      const std::lock_guard lock(mutex_);
      in_hand_.erase(*index);
      if (!result) {
        stop_with(result.error());
        break;
      }
      ++built_;
      if (tier_ == 0) release_rows();
    }
    std::unique_lock lock(mutex_);
    if (--running_ == 0) finished_.notify_all();
    finished_.wait(lock, [this] { return running_ == 0; });
    counts_ += job.counts();
    stages_ += job.clock().times();
  }

  [[nodiscard]] std::optional<std::int64_t> take_block() {
    const std::lock_guard lock(mutex_);
    if (options_.cancel != nullptr && options_.cancel->load() && next_ < blocks_.size()) stop_with({ErrorCode::kCancelled, "stopped"});
    if (stopped_ || next_ == blocks_.size()) return std::nullopt;
    in_hand_.insert(blocks_[next_]);
    return blocks_[next_++];
  }

  // Sources that cannot be read at random need not keep what lies above all blocks that are left. Under
  // mutex_.
  void release_rows() {
    std::optional<std::int64_t> first;
    if (!in_hand_.empty()) first = *in_hand_.begin();
    if (next_ < blocks_.size()) first = std::min(first.value_or(blocks_[next_]), blocks_[next_]);
    if (first) plan_.sampler->release_rows_before(work_.active(0, *first).y - plan_.info.data.y);
  }

  // An exception (out of memory) ends the build, not the process.
  [[nodiscard]] Result<void> run_block(BlockJob& job, std::int64_t index, const std::function<void(std::uint64_t)>& report) {
    try {
      return job.run(tier_, index, report, options_.cancel);
    } catch (const std::exception& problem) {
      const Error error = error_of(problem);
      return fail(error.code, "layer '" + plan_.info.name + "', level " + std::to_string(work_.tiers()[tier_].base.value) + ", block " +
                                  std::to_string(index) + ": " + error.message);
    }
  }

  void stop_with(const Error& error) {  // under mutex_
    if (!error_) error_ = error;
    stopped_ = true;
  }

  const LayerPlan& plan_;
  const WorkMap& work_;
  const LayerIds& ids_;
  std::size_t tier_;
  std::vector<std::int64_t> blocks_;
  store::StoreWriter& writer_;
  const BuildOptions& options_;
  WorkCounter& counter_;

  std::mutex mutex_;  // guards all that follows
  std::condition_variable finished_;
  std::size_t next_ = 0;
  std::set<std::int64_t> in_hand_;
  bool stopped_ = false;
  std::size_t running_ = 0;
  std::optional<Error> error_;
  std::int64_t built_ = 0;
  TileCounts counts_;
  StageTimes stages_;
};

// What comes after the blocks: passes over the finished tiles, then the layer is complete.
Result<void> finish_layer(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, const BuiltLayer& layer, int threads,
                          const BuildOptions& options, BuildReport& report) {
  PassFindings findings;
  VT_ASSIGN(findings.alpha_coverage, keep_coverage(writer, plan, layer, threads, options.cancel, report.tile_counts));
  const int fitting = build_memory(plan, layer.block_levels, threads).surface_threads(threads, options.memory_bytes);
  VT_ASSIGN(const std::vector<LevelQuality> surface, measure_surface(writer, plan, layer, fitting, options.cancel));
  if (!surface.empty()) findings.surface = measure_json({.name = "surface", .unit = "m"}, surface, 0);
  VT_ASSIGN(report.remarks, complete(writer, plan, work, layer, findings));
  return {};
}

// Compares a layer that is there with its sources. Afterwards the layer is either complete and up to date, or
// unfinished and committed so.
Result<void> find_changes(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, BuiltLayer& layer, int threads,
                          const BuildOptions& options, BuildReport& report) {
  VT_ASSIGN(SourceCheck check, check_sources(writer, plan, work, layer, threads, options));
  report.blocks_checked = check.checked;
  report.blocks_changed = static_cast<std::int64_t>(check.changed.size());
  report.stages += check.stages;
  if (check.changed.empty() && !layer.sources_differ) return {};
  const bool has_work = !check.changed.empty() || !layer.is_complete;
  VT_CHECK(begin_update(writer, plan, layer));
  if (!has_work) return finish_layer(writer, plan, work, layer, threads, options, report).map([&] { layer.is_complete = true; });
  VT_CHECK(mark_stale(writer, work, layer, std::move(check.changed)));
  return writer.commit();
}

Result<void> build_tiers(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, const BuiltLayer& layer, int threads,
                         const BuildOptions& options, BuildReport& report) {
  WorkCounter counter{.report = options.progress};
  std::vector<Pending> pending;
  for (std::size_t tier = 0; tier < work.tiers().size(); ++tier) {
    VT_ASSIGN(Pending one, find_pending(writer, work, layer, tier));
    counter.total += one.texels + one.done_texels;
    counter.done += one.done_texels;
    report.blocks_resumed += one.done_blocks;
    pending.push_back(std::move(one));
  }
  counter.add(0);
  for (std::size_t tier = 0; tier < work.tiers().size(); ++tier) {
    TierRun run(plan, work, layer.ids, tier, std::move(pending[tier].blocks), writer, options, counter);
    VT_CHECK(run.run(threads, report));
  }
  const auto start = Clock::now();
  VT_CHECK(finish_layer(writer, plan, work, layer, threads, options, report));
  report.commit_seconds += seconds_since(start);
  return {};
}

}  // namespace

bool is_of_the_data(ErrorCode code) {
  return code == ErrorCode::kInvalidData || code == ErrorCode::kUnsupported || code == ErrorCode::kCorrupt || code == ErrorCode::kUsage;
}

Result<BuildReport> build_layer(store::StoreWriter& writer, const LayerPlan& plan, const BuildOptions& options) {
  const auto start = Clock::now();
  BuildReport report;
  report.threads = thread_count(options.threads);
  int block_levels = options.block_levels;
  if (block_levels == 0) {
    VT_ASSIGN(block_levels, choose_block_levels(plan, report.threads, options.memory_bytes));
  }

  VT_ASSIGN(BuiltLayer layer, open_built_layer(writer, plan, block_levels, options.update));
  report.block_levels = layer.block_levels;
  report.base_texels = static_cast<std::uint64_t>(plan.info.data.width) * static_cast<std::uint64_t>(plan.info.data.height);
  const WorkMap work(plan, layer.block_levels);
  if (!layer.remark.empty() && options.remark) options.remark(layer.remark);
  if (layer.was_there) VT_CHECK(note_failure(writer, layer, false));
  const bool goes_on_from_others = layer.sources_differ && !layer.was_complete;
  if (layer.was_there && (options.update || goes_on_from_others)) {
    if (auto found = find_changes(writer, plan, work, layer, report.threads, options, report); !found) {
      [[maybe_unused]] const auto kept = writer.commit();
      return tl::unexpected(std::move(found).error());
    }
  }
  report.was_complete = layer.is_complete;
  if (!layer.is_complete) {
    auto built = build_tiers(writer, plan, work, layer, report.threads, options, report);
    if (!built) {
      // What is done is kept, whatever stopped the rest. If it was the store itself, it refuses, and the
      // first error is the one to tell.
      [[maybe_unused]] const auto noted = note_failure(writer, layer, is_of_the_data(built.error().code));
      [[maybe_unused]] const auto kept = writer.commit();
      return tl::unexpected(std::move(built).error());
    }
  }

  const auto info = writer.find_layer(plan.info.name);
  report.tiles = info->tiles;
  report.constant_tiles = info->constant_tiles;
  report.stored_bytes = info->stored_bytes;
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace vt::pipeline
