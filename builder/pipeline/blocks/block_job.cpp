#include "builder/pipeline/blocks/block_job.h"

#include <algorithm>
#include <array>
#include <string>

#include "builder/pipeline/blocks/block_quality.h"
#include "builder/pipeline/plan/feed_rows.h"
#include "builder/pyramid/make_cascade.h"

namespace vt::pipeline {
namespace {

// Calls use(chunk in layer texels) for every piece of `active` that is read at once. Chunks end on multiples
// of their height, so that neighbouring blocks ask the source for the same rows.
template <class Use>
Result<void> for_each_chunk(const TexelRect& active, const Use& use) {
  for (std::int64_t y = active.y; y < active.bottom();) {
    const std::int64_t end = std::min((y / kChunkRows + 1) * kChunkRows, active.bottom());
    VT_CHECK(use(TexelRect{active.x, y, active.width, end - y}));
    y = end;
  }
  return {};
}

}  // namespace

BlockJob::BlockJob(const LayerPlan& plan, const WorkMap& work, const LayerIds& ids, store::StoreWriter& writer, bool timed)
    : plan_(plan), work_(work), ids_(ids), writer_(writer), marks_(writer, ids.marks), clock_(timed) {}

Result<void> BlockJob::put_blob(LayerId layer, TileId tile, std::span<const std::byte> bytes) {
  VT_ASSIGN(const store::PayloadView payload, store::encode_payload(bytes, {store::Codec::kZstd, 1}, compressed_));
  const InStage stage(clock_, Stage::kStore);
  VT_ASSIGN(const bool is_there, writer_.holds(layer, tile, payload));
  return is_there ? Result<void>{} : writer_.put(layer, tile, payload);
}

Result<void> BlockJob::run(std::size_t tier_index, std::int64_t index, const std::function<void(std::uint64_t)>& progress,
                           const std::atomic<bool>* cancel) {
  const InStage stage(clock_, Stage::kFilter);
  const Tier& tier = work_.tiers()[tier_index];
  const bool has_mark = tier_index == 0 || tier.has_carry;  // the last block has none; after it the layer is complete
  if (has_mark) VT_CHECK(marks_.begin(tier, index));
  const std::unique_ptr<pyramid::Cascade> made =
      pyramid::make_cascade(work_.plan_block(tier_index, index), plan_.shape(), tier.outputs, plan_.sampler->codec(), plan_.kernel,
                            plan_.info.tile_exponent, area_exponent(plan_));
  pyramid::Cascade& cascade = *made;
  TileOutput output({plan_, ids_, writer_, counts_, clock_}, tier, cascade);
  start_content();
  if (tier_index == 0) {
    VT_CHECK(feed_from_sources(cascade, output, progress, cancel));
  } else {
    VT_CHECK(feed_from_carry(tier_index, cascade, output, cancel));
    progress(work_.core_texels(tier_index, index));
  }
  VT_CHECK(output.status());
  if (tier.has_carry) {
    const InStage carry(clock_, Stage::kEncode);
    cascade.carry_bytes(blob_);
    VT_CHECK(put_blob(ids_.carry, tier.carry_tile(index), blob_));
  }
  write_block_quality(output.quality(), blob_);
  if (!blob_.empty()) VT_CHECK(put_blob(ids_.quality, quality_tile(tier, index), blob_));
  if (!has_mark) return {};
  return marks_.set(tier, index, tier_index == 0 ? content_.digest() : carry_mark());
}

// Counts of one layer are of one unit: blocks that were counted in another are built again.
void BlockJob::start_content() {
  content_.reset();
  const int exponent = area_exponent(plan_);
  if (exponent > 0) content_.add(std::array{static_cast<std::byte>(exponent)});
}

Result<store::ContentHash> BlockJob::source_hash(std::int64_t index) {
  const InStage stage(clock_, Stage::kCheck);
  start_content();
  VT_CHECK(for_each_chunk(work_.active(0, index), [&](const TexelRect& rect) { return chunk_.hash(plan_, rect, content_); }));
  return content_.digest();
}

Result<void> BlockJob::feed_from_sources(pyramid::Cascade& cascade, TileOutput& output, const std::function<void(std::uint64_t)>& progress,
                                         const std::atomic<bool>* cancel) {
  const TexelRect active = cascade.level(0).active;
  const TexelRect core = cascade.level(0).core;
  const channels::ChannelCodec& codec = plan_.sampler->codec();
  const auto feed = [&](const TexelRect& rect) -> Result<void> {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return fail(ErrorCode::kCancelled, "stopped");
    {
      const InStage stage(clock_, Stage::kRead);
      VT_CHECK(chunk_.load(plan_, rect, &content_));
    }
    feed_rows(chunk_, rect, codec, cascade, output, [&](std::int64_t y, const channels::PlaneRow& planes) {
      const InStage decoding(clock_, Stage::kDecode);
      return chunk_.decode_row(codec, y, planes);
    });
    VT_CHECK(cascade.status());
    VT_CHECK(output.status());
    const TexelRect done = intersect(core, {core.x, rect.y, core.width, rect.height});
    progress(static_cast<std::uint64_t>(done.width * done.height));
    return {};
  };
  return for_each_chunk(active, feed);
}

// The tiles of carry_columns_ in one row. Where no source reaches there is no carry.
Result<void> BlockJob::load_carry_band(std::size_t tier, std::int64_t tile_row) {
  const InStage stage(clock_, Stage::kCarry);
  const Tier& here = work_.tiers()[tier];
  const Tier& finer = work_.tiers()[tier - 1];
  carry_band_.resize(carry_columns_.size());
  for (std::size_t i = 0; i < carry_columns_.size(); ++i) {
    const TileId id{here.base, static_cast<std::uint32_t>(carry_columns_[i]), static_cast<std::uint32_t>(tile_row)};
    if (!writer_.contains(ids_.carry, id) && !work_.is_touched(tier - 1, finer.block_of_carry(id))) {
      carry_band_[i].clear();
    } else {
      VT_CHECK(writer_.read_blob(ids_.carry, id, carry_band_[i]));
    }
  }
  return {};
}

Result<void> BlockJob::feed_from_carry(std::size_t tier, pyramid::Cascade& cascade, TileOutput& output, const std::atomic<bool>* cancel) {
  const TexelRect active = cascade.level(0).active;
  const int exponent = plan_.info.tile_exponent;
  carry_columns_ = pyramid::carry_columns(cascade.level(0), exponent);
  for (std::int64_t row = active.y >> exponent; row <= (active.bottom() - 1) >> exponent; ++row) {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return fail(ErrorCode::kCancelled, "stopped");
    VT_CHECK(load_carry_band(tier, row));
    VT_CHECK(cascade.feed_carry({.row = row, .columns = carry_columns_, .tiles = carry_band_}, output));
    VT_CHECK(output.status());
  }
  return {};
}

}  // namespace vt::pipeline
