#include "builder/pipeline/block_job.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace vt::pipeline {
namespace {

// Calls use(chunk in layer texels) for every piece of `active` that is read at once. Chunks end on multiples of their height, so that
// neighbouring blocks ask the source for the same rows.
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

// Takes finished rows from the cascade: texel levels into bands of tiles, the level above them into the carry tile.
class BlockJob::Output final : public pyramid::RowSink {
 public:
  Output(BlockJob& job, const Tier& tier, TileId carry_tile, const pyramid::BlockCascade& cascade)
      : job_(job),
        carry_tile_(carry_tile),
        outputs_(tier.outputs),
        base_core_(cascade.level(0).core),
        has_base_texels_(static_cast<std::size_t>(base_core_.height), false) {
    const LayerInfo& info = job.plan_.info;
    for (int k = 0; k < tier.outputs; ++k)
      bands_.emplace_back(info, job.plan_.sampler->codec(), job.plan_.compression, Level{static_cast<std::uint8_t>(tier.base.value - k)},
                          cascade.level(k).core);
    if (tier.has_carry) {
      const std::size_t edge = info.tile_texels();
      carry_.assign(edge * edge * static_cast<std::size_t>(carry_floats()), 0.0F);
      carry_core_ = cascade.level(tier.outputs).core;
    }
  }

  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    if (!status_) return;
    const InStage stage(job_.clock_, Stage::kQuantise);
    if (k == outputs_) {
      keep_carry_row(y, rows.here);
    } else if (k > 0 || !has_base_texels_[static_cast<std::size_t>(y - base_core_.y)]) {
      bands_[static_cast<std::size_t>(k)].add_row(y, rows);
      store_finished(k);
    }
  }

  // Row `y` of the base will come as texels, not as planes. To be said before its planes are written.
  void expect_base_texels(std::int64_t y) { has_base_texels_[static_cast<std::size_t>(y - base_core_.y)] = true; }

  void base_texels(std::int64_t y, const std::byte* texels, const float* weights) {
    if (!status_) return;
    const InStage stage(job_.clock_, Stage::kQuantise);
    bands_[0].add_texels(y, texels, weights);
    store_finished(0);
  }

  [[nodiscard]] const Result<void>& status() const { return status_; }

  // The carry tile comes after all others.
  [[nodiscard]] Result<void> finish() {
    VT_CHECK(status_);
    if (carry_.empty()) return {};
    const InStage stage(job_.clock_, Stage::kEncode);
    const std::size_t texel_bytes = static_cast<std::size_t>(carry_floats()) * sizeof(float);
    const auto raw = std::as_bytes(std::span(carry_));
    encode::EncodedTile tile;
    tile.tile = carry_tile_;
    std::vector<std::byte> compressed;
    if (encode::is_one_value(raw, texel_bytes)) {
      tile.constant_block = raw.first(texel_bytes);
    } else {
      const store::TileShape shape = store::tile_shape(job_.plan_.sampler->codec().carry_format(), job_.plan_.info.tile_texels());
      VT_ASSIGN(tile.payload, store::encode_payload(raw, shape, {store::Codec::kZstd, 1}, compressed));
    }
    return job_.put(job_.ids_.carry, tile);
  }

 private:
  [[nodiscard]] int carry_floats() const { return format_info(job_.plan_.sampler->codec().carry_format()).channels; }

  void keep_carry_row(std::int64_t y, const channels::ConstPlaneRow& row) {
    const std::int64_t edge = job_.plan_.info.tile_texels();
    const auto floats = carry_floats();
    float* out = carry_.data() + ((y & (edge - 1)) * edge + (carry_core_.x & (edge - 1))) * floats;
    for (std::int64_t x = 0; x < carry_core_.width; ++x)
      for (int p = 0; p < floats; ++p) *out++ = row[static_cast<std::size_t>(p)][x];
  }

  void store_finished(int k) {
    const InStage stage(job_.clock_, Stage::kEncode);
    status_ = bands_[static_cast<std::size_t>(k)].take_finished(
        [this](const encode::EncodedTile& tile) { return job_.put(job_.ids_.texture, tile); });
  }

  BlockJob& job_;
  TileId carry_tile_;
  int outputs_;
  TexelRect base_core_;
  std::vector<bool> has_base_texels_;  // by row of the core
  std::vector<encode::TileBand> bands_;
  std::vector<float> carry_;
  TexelRect carry_core_;
  Result<void> status_;
};

BlockJob::BlockJob(const LayerPlan& plan, const WorkMap& work, LayerIds ids, store::StoreWriter& writer, bool timed)
    : plan_(plan), work_(work), ids_(ids), writer_(writer), marks_(writer, ids.marks), clock_(timed) {}

Result<void> BlockJob::put(LayerId layer, const encode::EncodedTile& tile) {
  const InStage stage(clock_, Stage::kStore);
  TileCounts ignored;
  TileCounts& counts = layer == ids_.texture ? counts_ : ignored;
  if (tile.is_empty) {
    // A rebuilt block may find nothing where there was something.
    if (!writer_.contains(layer, tile.tile)) return {};
    ++counts.removed;
    return writer_.remove(layer, tile.tile);
  }
  // What a rebuilt block finds as it was costs no new bytes.
  const bool is_constant = !tile.constant_block.empty();
  VT_ASSIGN(const bool is_there,
            is_constant ? writer_.holds_constant(layer, tile.tile, tile.constant_block) : writer_.holds(layer, tile.tile, tile.payload));
  if (is_there) {
    ++counts.unchanged;
    return {};
  }
  ++counts.written;
  return is_constant ? writer_.put_constant(layer, tile.tile, tile.constant_block) : writer_.put(layer, tile.tile, tile.payload);
}

Result<void> BlockJob::run(std::size_t tier_index, std::int64_t index, const std::function<void(std::uint64_t)>& progress,
                           const std::atomic<bool>* cancel) {
  const InStage stage(clock_, Stage::kFilter);
  const Tier& tier = work_.tiers()[tier_index];
  const channels::ChannelCodec& codec = plan_.sampler->codec();
  pyramid::BlockCascade cascade(pyramid::plan_block(tier.block(index), tier.data, tier.outputs, tier.has_carry, plan_.kernel),
                                codec.planes(), plan_.kernel);
  Output output(*this, tier, tier.has_carry ? tier.carry_tile(index) : TileId{}, cascade);
  content_.reset();
  if (tier_index == 0) {
    VT_CHECK(feed_from_sources(cascade, output, progress, cancel));
  } else {
    VT_CHECK(feed_from_carry(tier_index, cascade, output));
    progress(work_.core_texels(tier_index, index));
  }
  VT_CHECK(output.finish());
  if (tier_index > 0 && !tier.has_carry) return {};  // the last block; after it the layer is complete
  return marks_.set(tier, index, tier_index == 0 ? content_.digest() : carry_mark());
}

Result<store::ContentHash> BlockJob::source_hash(std::int64_t index) {
  const InStage stage(clock_, Stage::kCheck);
  content_.reset();
  VT_CHECK(for_each_chunk(work_.active(0, index), [&](const TexelRect& rect) {
    return plan_.sampler->hash(from_corner_of(plan_.info.data, rect), chunk_, content_);
  }));
  return content_.digest();
}

Result<void> BlockJob::feed_from_sources(pyramid::BlockCascade& cascade, Output& output, const std::function<void(std::uint64_t)>& progress,
                                         const std::atomic<bool>* cancel) {
  const TexelRect active = cascade.level(0).active;
  const TexelRect core = cascade.level(0).core;
  const auto weight_plane = static_cast<std::size_t>(plan_.sampler->codec().weight_plane());
  const auto texel_bytes = static_cast<std::int64_t>(format_info(plan_.sampler->codec().texel_format()).block_bytes);
  const auto feed = [&](const TexelRect& rect) -> Result<void> {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return fail(ErrorCode::kCancelled, "stopped");
    {
      const InStage stage(clock_, Stage::kRead);
      VT_CHECK(plan_.sampler->load(from_corner_of(plan_.info.data, rect), chunk_, &content_));
    }
    for (std::int64_t row = rect.y; row < rect.bottom(); ++row) {
      const channels::PlaneRow planes = cascade.begin_row();
      const Stage before = clock_.enter(Stage::kDecode);
      const bool opaque = chunk_.decode_row(row - rect.y, planes);
      clock_.enter(before);
      const std::byte* texels = chunk_.texel_row(row - rect.y);
      const bool is_texels = texels != nullptr && row >= core.y && row < core.bottom();
      // Rows of planes come out one row late: the texels of this row follow what ending it sends on.
      if (is_texels) output.expect_base_texels(row);
      cascade.end_row(opaque, output);
      if (is_texels) {
        const std::int64_t west = core.x - active.x;
        output.base_texels(row, texels + west * texel_bytes, opaque ? nullptr : planes[weight_plane] + west);
      }
    }
    VT_CHECK(output.status());
    const TexelRect done = intersect(core, {core.x, rect.y, core.width, rect.height});
    progress(static_cast<std::uint64_t>(done.width * done.height));
    return {};
  };
  return for_each_chunk(active, feed);
}

// Where no source reaches there is no carry, which is the same as carry without any weight.
Result<void> BlockJob::load_carry_band(std::size_t tier, std::int64_t tile_row, const TexelRect& active) {
  const InStage stage(clock_, Stage::kCarry);
  const Tier& here = work_.tiers()[tier];
  const Tier& finer = work_.tiers()[tier - 1];
  const int exponent = plan_.info.tile_exponent;
  const std::int64_t first = active.x >> exponent;
  const std::int64_t last = (active.right() - 1) >> exponent;
  const std::size_t edge = plan_.info.tile_texels();
  const auto floats = static_cast<std::size_t>(format_info(plan_.sampler->codec().carry_format()).channels);
  carry_band_.resize(static_cast<std::size_t>(last - first + 1));
  for (std::int64_t column = first; column <= last; ++column) {
    std::vector<float>& tile = carry_band_[static_cast<std::size_t>(column - first)];
    tile.resize(edge * edge * floats);
    const TileId id{here.base, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(tile_row)};
    if (!writer_.contains(ids_.carry, id) && !work_.is_touched(tier - 1, finer.block_of_carry(id))) {
      std::fill(tile.begin(), tile.end(), 0.0F);
      continue;
    }
    VT_CHECK(writer_.read(ids_.carry, id, std::as_writable_bytes(std::span(tile))));
  }
  return {};
}

Result<void> BlockJob::feed_from_carry(std::size_t tier, pyramid::BlockCascade& cascade, Output& output) {
  const TexelRect active = cascade.level(0).active;
  const int exponent = plan_.info.tile_exponent;
  const std::int64_t edge = plan_.info.tile_texels();
  const auto floats = static_cast<std::int64_t>(format_info(plan_.sampler->codec().carry_format()).channels);
  const auto weight_plane = static_cast<std::size_t>(plan_.sampler->codec().weight_plane());
  std::optional<std::int64_t> loaded_row;
  for (std::int64_t y = active.y; y < active.bottom(); ++y) {
    if (loaded_row != y >> exponent) {
      loaded_row = y >> exponent;
      VT_CHECK(load_carry_band(tier, *loaded_row, active));
    }
    const channels::PlaneRow planes = cascade.begin_row();
    bool opaque = true;
    for (std::int64_t x = active.x; x < active.right();) {
      const std::int64_t column = x >> exponent;
      const std::int64_t end = std::min((column + 1) << exponent, active.right());
      const float* from = carry_band_[static_cast<std::size_t>(column - (active.x >> exponent))].data() +
                          ((y & (edge - 1)) * edge + (x & (edge - 1))) * floats;
      for (; x < end; ++x, from += floats) {
        for (std::int64_t p = 0; p < floats; ++p) planes[static_cast<std::size_t>(p)][x - active.x] = from[p];
        opaque = opaque && from[weight_plane] == 1.0F;
      }
    }
    cascade.end_row(opaque, output);
    VT_CHECK(output.status());
  }
  return {};
}

}  // namespace vt::pipeline
