#include "builder/pipeline/build/source_check.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <mutex>
#include <numeric>

#include "builder/pipeline/parallel/parallel.h"

namespace vt::pipeline {
namespace {

// Blocks of a tier that have a mark but no source under them, ascending: what sources that are gone have left
// behind.
Result<std::vector<std::int64_t>> abandoned_blocks(const BlockMarks& marks, const WorkMap& work, std::size_t tier) {
  std::vector<std::int64_t> found;
  for (std::int64_t index = 0; index < work.tiers()[tier].blocks(); ++index) {
    if (work.is_touched(tier, index)) continue;
    VT_ASSIGN(const auto mark, marks.find(work.tiers()[tier], index));
    if (mark) found.push_back(index);
  }
  return found;
}

std::vector<std::int64_t> merged(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::vector<std::int64_t> all;
  std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

// The last block of a layer of several tiers has no mark: it is built whenever the layer is not complete.
bool has_marks(const WorkMap& work, std::size_t tier) { return tier == 0 || work.tiers()[tier].has_carry; }

}  // namespace

Result<SourceCheck> check_sources(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, const BuiltLayer& layer,
                                  int threads, const BuildOptions& options) {
  const BlockMarks marks(writer, layer.ids.marks);
  std::vector<std::int64_t> candidates = work.touched(0);
  if (layer.sources_differ || layer.is_updating) {
    VT_ASSIGN(const auto abandoned, abandoned_blocks(marks, work, 0));
    candidates = merged(candidates, abandoned);
  }

  SourceCheck check;
  check.checked = static_cast<std::int64_t>(candidates.size());
  std::atomic<std::uint64_t> done{0};
  std::mutex mutex;                                  // guards what follows, and check.changed
  std::vector<std::unique_ptr<BlockJob>> idle_jobs;  // their buffers are large, so they are lent from block to block
  const auto borrow_job = [&] {
    const std::lock_guard lock(mutex);
    if (idle_jobs.empty()) return std::make_unique<BlockJob>(plan, work, layer.ids, writer, options.with_stats);
    auto job = std::move(idle_jobs.back());
    idle_jobs.pop_back();
    return job;
  };
  const auto compare = [&](std::size_t i) -> Result<void> {
    if (options.cancel != nullptr && options.cancel->load()) return fail(ErrorCode::kCancelled, "stopped");
    VT_ASSIGN(const auto mark, marks.find(work.tiers()[0], candidates[i]));
    bool is_same = false;
    auto job = borrow_job();
    if (mark && *mark != kStaleMark) {
      VT_ASSIGN(const store::ContentHash now, job->source_hash(candidates[i]));
      is_same = now == *mark;
    }
    {
      const std::lock_guard lock(mutex);
      if (!is_same) check.changed.push_back(candidates[i]);
      idle_jobs.push_back(std::move(job));
    }
    const std::uint64_t count = ++done;
    if (options.check_progress) options.check_progress(count, candidates.size());
    return {};
  };
  VT_CHECK(for_each_index(candidates.size(), threads, compare));
  for (const auto& job : idle_jobs) check.stages += job->clock().times();
  std::sort(check.changed.begin(), check.changed.end());
  return check;
}

Result<void> mark_stale(store::StoreWriter& writer, const WorkMap& work, const BuiltLayer& layer, std::vector<std::int64_t> changed) {
  BlockMarks marks(writer, layer.ids.marks);
  for (std::size_t tier = 0; tier < work.tiers().size() && has_marks(work, tier); ++tier) {
    std::vector<std::int64_t> above;
    for (const std::int64_t index : changed) {
      // A block that was never built needs no mark to be built.
      VT_ASSIGN(const auto mark, marks.find(work.tiers()[tier], index));
      if (mark) VT_CHECK(marks.set(work.tiers()[tier], index, kStaleMark));
      const auto dependents = work.dependents(tier, index);
      above.insert(above.end(), dependents.begin(), dependents.end());
    }
    std::sort(above.begin(), above.end());
    above.erase(std::unique(above.begin(), above.end()), above.end());
    changed = std::move(above);
  }
  return {};
}

Result<Pending> find_pending(store::StoreWriter& writer, const WorkMap& work, const BuiltLayer& layer, std::size_t tier) {
  Pending pending;
  const BlockMarks marks(writer, layer.ids.marks);
  if (!has_marks(work, tier)) {
    pending.blocks.resize(static_cast<std::size_t>(work.tiers()[tier].blocks()));
    std::iota(pending.blocks.begin(), pending.blocks.end(), 0);
  } else {
    std::vector<std::int64_t> candidates = work.touched(tier);
    if (layer.is_updating) {
      VT_ASSIGN(const auto abandoned, abandoned_blocks(marks, work, tier));
      candidates = merged(candidates, abandoned);
    }
    for (const std::int64_t index : candidates) {
      VT_ASSIGN(const auto mark, marks.find(work.tiers()[tier], index));
      if (mark && *mark != kStaleMark) {
        ++pending.done_blocks;
        pending.done_texels += work.core_texels(tier, index);
      } else {
        pending.blocks.push_back(index);
      }
    }
  }
  for (const std::int64_t index : pending.blocks) pending.texels += work.core_texels(tier, index);
  return pending;
}

}  // namespace vt::pipeline
