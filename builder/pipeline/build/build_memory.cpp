#include "builder/pipeline/build/build_memory.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "builder/encode/reference_rows.h"
#include "builder/pipeline/build/plan_cost.h"
#include "builder/pipeline/passes/surface_pass.h"
#include "builder/pyramid/cascade.h"
#include "builder/pyramid/class_counts.h"
#include "builder/pyramid/halve_planes.h"
#include "builder/pyramid/plane_rows.h"
#include "builder/pyramid/reduce_rows.h"
#include "builder/source/cells/block_cache.h"
#include "builder/source/files/file_pool.h"
#include "store/codec/codec.h"
#include "store/index/known_payloads.h"
#include "store/index/page_cache.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

constexpr std::size_t kSourceBytes = 4096;       // one open source without its samples, measured on 10,000 GeoTIFFs
constexpr std::size_t kDecoderBytes = 96 << 10;  // an idle TIFF decoder without the stored block in it
constexpr std::size_t kBlockListBytes = 32;      // of a block in the lists of what is to be done
constexpr std::size_t kThreadBytes = 256 << 10;  // stack in use, the allocator's own

// The widest block of a tier: one in the middle of the layer, as far as the data reach.
std::vector<pyramid::BlockLevel> widest_block(const LayerPlan& plan, const Tier& tier) {
  const std::int64_t edge = tier.block_texels;
  std::vector<pyramid::BlockLevel> block =
      pyramid::plan_block({edge, edge, edge, edge}, {0, 0, 3 * edge, 3 * edge}, tier.outputs, tier.has_carry, plan.kernel);
  for (std::size_t k = 0; k < block.size(); ++k) {
    pyramid::BlockLevel& level = block[k];
    const std::int64_t data = coarser(tier.data, static_cast<int>(k)).width;
    const std::int64_t apron = (level.active.width - level.core.width) / 2;
    level.core.width = std::min(level.core.width, data);
    level.active.width = std::min(level.active.width, plan.is_closed ? data + 2 * apron : data);
    // A closed layer has up to two texels of the coarsest level more: see WorkMap::seam_apron.
    if (plan.is_closed) level.beyond.width = apron + 2 * (level.core.width >> plan.info.tile_exponent) + 2;
  }
  return block;
}

// Different classes in one texel that lies `depth` levels above the finest, on average over a row. Noise of
// many classes has more, up to all of the format; of four land cover maps of 7 to 19 classes (Berlin, Zion,
// crops of Iowa at 3 m, Pennsylvania at 1 m) none had more than 12 in a texel of 64 x 64, 14 in one of 256 x
// 256. A texel of the finest level has one, unless it lies over many samples.
std::size_t classes_per_texel(const LayerPlan& plan, int depth) {
  constexpr std::size_t kClasses = 16;
  return depth < 2 && area_exponent(plan) == 0 ? std::size_t{1} << (2 * depth) : kClasses;
}

// The memory of a ClassCascade: rows of planes, and of each level but the base two rows of counts with room
// for all that the finer two rows have.
std::size_t class_cascade_bytes(const LayerPlan& plan, const std::vector<pyramid::BlockLevel>& block, int depth) {
  constexpr std::size_t kRingRows = 4;
  const auto planes = static_cast<std::size_t>(plan.codec->planes());
  std::size_t bytes = 0;
  for (std::size_t k = 0; k < block.size(); ++k) {
    const std::size_t width = static_cast<std::size_t>(block[k].active.width + block[k].beyond.width) + 2;
    bytes += kRingRows * planes * width * sizeof(float);
    const int finer = std::max(0, depth + static_cast<int>(k) - 1);
    bytes += 2 * width * (sizeof(std::uint32_t) + 5 * classes_per_texel(plan, finer) * sizeof(pyramid::ClassCount));
  }
  return bytes;
}

std::size_t cascade_bytes(const LayerPlan& plan, const std::vector<pyramid::BlockLevel>& block, int depth) {
  if (plan.codec->class_counting()) return class_cascade_bytes(plan, block, depth);
  const auto stride = [](const pyramid::BlockLevel& level) {
    constexpr std::int64_t kPads = 2 * pyramid::PlaneRows::kPad;
    const std::int64_t beyond = level.beyond.width > 0 ? level.beyond.width + kPads : 0;
    return static_cast<std::size_t>(level.active.width + kPads + beyond);
  };
  const auto rows = static_cast<std::size_t>(pyramid::PlaneHalver::rows_needed(plan.kernel)) + 1;  // and one without data
  const auto planes = static_cast<std::size_t>(plan.codec->planes());
  std::size_t floats = 0;
  for (const pyramid::BlockLevel& level : block) floats += rows * planes * stride(level);
  const std::size_t widest = stride(block.front());
  // A kernel of more than two taps adds up rows first, then goes along them.
  if (plan.kernel.taps > 2) floats += planes * (widest + pyramid::halve_scratch_floats(widest / 2));
  return (floats + widest) * sizeof(float);
}

// A row of tiles of every part of every level, the planes of the rows of each level that are measured, and of
// each part one tile on its way through the encoders.
std::size_t tile_bytes(const LayerPlan& plan, const Tier& tier, const std::vector<pyramid::BlockLevel>& block) {
  const std::size_t edge = plan.info.tile_texels();
  const auto planes = static_cast<std::size_t>(plan.codec->planes());
  std::size_t bytes = 0;
  for (int k = 0; k < tier.outputs; ++k) {
    const auto width = static_cast<std::size_t>(block[static_cast<std::size_t>(k)].core.width);
    const std::size_t tiles = (width + edge - 1) / edge;
    const Level level{static_cast<std::uint8_t>(tier.base.value - k)};
    if (!plan.codec->measures().empty())
      bytes += static_cast<std::size_t>(encode::measured_rows_of_tile(plan.info, level)) * planes * width * sizeof(float);
    for (std::size_t part = 0; part < plan.parts.size(); ++part) {
      if (level == plan.info.finest ? plan.part(part).starts_above_base : plan.part(part).ends_at_base) continue;
      const std::size_t payload = plan.parts[part].tile_payload_bytes();
      const std::size_t raw = edge * edge * format_info(plan.part(part).texel_format).block_bytes;
      bytes += tiles * raw + 4 * edge * 4 * sizeof(float);
      if (plan.part(part).format != plan.part(part).texel_format) bytes += payload;
      if (plan.compression.codec != store::Codec::kRaw) bytes += payload + payload / 128;
    }
  }
  return bytes;
}

std::size_t tier_bytes(const LayerPlan& plan, const Tier& tier, bool is_first) {
  const std::vector<pyramid::BlockLevel> block = widest_block(plan, tier);
  const std::size_t edge = plan.info.tile_texels();
  const int depth = plan.info.finest.value - tier.base.value;
  // A class takes four bytes of packed counts, seven where they count parts of texels.
  const std::size_t class_bytes = area_exponent(plan) > 0 ? 7 : 4;
  const std::size_t carry_texel = plan.codec->class_counting() ? 1 + class_bytes * classes_per_texel(plan, depth + tier.outputs)
                                                               : static_cast<std::size_t>(plan.codec->planes()) * sizeof(float);
  const std::size_t carry_tile = edge * edge * carry_texel;
  std::size_t bytes = cascade_bytes(plan, block, depth) + tile_bytes(plan, tier, block);
  std::size_t compressor = 0;
  for (const LayerInfo& part : plan.parts)
    compressor = std::max(compressor, store::compressor_bytes(plan.compression, part.tile_payload_bytes()));
  if (tier.has_carry) {
    bytes += 3 * carry_tile;  // as floats, as residuals, compressed
    compressor = std::max(compressor, store::compressor_bytes({store::Codec::kZstd, 1}, carry_tile));
  }
  bytes += compressor;
  const std::int64_t width = block.front().active.width;
  if (is_first) return bytes + plan.source_load.chunk_bytes(width, *plan.codec) + plan.source_load.reader_bytes;
  return bytes + 2 * (static_cast<std::size_t>(width) / edge + 2) * carry_tile;  // a row of tiles of the tier before, packed and not
}

// What one tier has freed is not always given back before the next.
std::size_t worker_bytes(const LayerPlan& plan, int levels) {
  std::size_t most = 0;
  std::size_t sum = 0;
  const std::vector<Tier> tiers = plan_tiers(plan.info, levels);
  for (std::size_t i = 0; i < tiers.size(); ++i) {
    const std::size_t bytes = tier_bytes(plan, tiers[i], i == 0);
    most = std::max(most, bytes);
    sum += bytes;
  }
  return kThreadBytes + most + std::min(most, sum - most) / 4;
}

std::size_t sources_bytes(const SourceLoad& load, std::size_t cache_bytes, int threads) {
  // Each thread's own is counted with the thread; those of other files stay for a while.
  const std::size_t decoders =
      std::min(source::FilePool::kMostIdleReaders, (std::max<std::size_t>(load.count, 1) - 1) * static_cast<std::size_t>(threads));
  const auto hashes = static_cast<std::size_t>(std::min<std::uint64_t>(source::BlockCache::kMostHashes, load.file_blocks));
  return load.count * kSourceBytes + static_cast<std::size_t>(std::min<std::uint64_t>(cache_bytes, load.sample_bytes)) +
         decoders * (kDecoderBytes + load.stored_block_bytes) + hashes * source::BlockCache::kBytesOfHash;
}

std::size_t store_bytes(const LayerPlan& plan, int levels) {
  const std::uint64_t tiles = plan_cost(plan).tiles;
  const std::vector<Tier> tiers = plan_tiers(plan.info, levels);
  std::uint64_t blocks = 0;
  for (const Tier& tier : tiers) blocks += static_cast<std::uint64_t>(tier.blocks());
  // When there are a few islands in a wide sea, only the blocks under them are ever listed; coarser tiers
  // have fewer.
  if (plan.sampler) {
    const Tier& base = tiers.front();
    constexpr std::uint64_t kCoarser = 2;  // times as many blocks, all tiers together
    const std::uint64_t touched = plan.sampler->most_squares_touched(base.block_texels, base.block_texels);  // no apron is wider
    blocks = std::min(blocks, kCoarser * touched + tiers.size());
  }
  // Pages hold 1024 tiles and are cut by the data's edges; the parts, the carry, the marks and the quality
  // have pages of their own.
  constexpr std::uint64_t kHelpers = 3;
  const std::uint64_t pages =
      tiles / 512 + kHelpers * blocks / 512 + (plan.parts.size() + kHelpers) * static_cast<std::uint64_t>(plan.info.finest.value + 1);
  const auto index = static_cast<std::size_t>(std::min<std::uint64_t>(store::PageCache::kMostBytes, pages * store::PageCache::kPageBytes));
  const auto values = static_cast<std::size_t>(std::min<std::uint64_t>(store::KnownPayloads::kMost, tiles + blocks));
  return index + values * store::KnownPayloads::kBytesOfOne + static_cast<std::size_t>(blocks) * kBlockListBytes;
}

std::string mebibytes(std::size_t bytes) { return std::to_string((bytes + kMebibyte - 1) / kMebibyte) + "M"; }

BuildMemory memory_with_cache(const LayerPlan& plan, int levels, int threads, std::size_t cache_bytes) {
  BuildMemory memory;
  memory.program = kProgramBytes + (plan.source_load.has_pictures ? kPictureLibraryBytes : 0);
  memory.sources = sources_bytes(plan.source_load, cache_bytes, threads);
  memory.store = store_bytes(plan, levels);
  memory.worker = worker_bytes(plan, levels);
  const std::size_t surface = surface_thread_bytes(plan);
  if (surface > 0) memory.surface = kThreadBytes + surface;
  return memory;
}

int widest_levels(const LayerPlan& plan) { return std::max(1, 12 - int{plan.info.tile_exponent}); }

std::optional<int> widest_fit(const LayerPlan& plan, int threads, std::size_t memory_bytes) {
  for (int levels = widest_levels(plan); levels >= 1; --levels)
    if (build_memory(plan, levels, threads).total(threads) <= memory_bytes) return levels;
  return std::nullopt;
}

// What a build needs that is told to use no more than that, in whole mebibytes: with more memory its sources
// keep more, too.
std::size_t enough_memory(const LayerPlan& plan, int threads) {
  const int levels = cheapest_block_levels(plan, threads);
  std::size_t cache_bytes = plan.source_load.cache_bytes;
  while (true) {
    const std::size_t bytes = memory_with_cache(plan, levels, threads, cache_bytes).total(threads);
    const std::size_t whole = (bytes + kMebibyte - 1) / kMebibyte * kMebibyte;
    if (source_cache_bytes(whole) <= cache_bytes) return whole;
    cache_bytes = source_cache_bytes(whole);
  }
}

}  // namespace

BuildMemory build_memory(const LayerPlan& plan, int levels, int threads) {
  return memory_with_cache(plan, levels, threads, plan.source_load.cache_bytes);
}

int BuildMemory::surface_threads(int threads, std::size_t memory_bytes) const {
  const std::size_t rest = memory_bytes - std::min(memory_bytes, program + sources + store);
  return surface == 0 ? threads : static_cast<int>(std::clamp<std::size_t>(rest / surface, 1, static_cast<std::size_t>(threads)));
}

int cheapest_block_levels(const LayerPlan& plan, int threads) {
  int best = 1;
  for (int levels = 2; levels <= widest_levels(plan); ++levels)
    if (build_memory(plan, levels, threads).total(threads) <= build_memory(plan, best, threads).total(threads)) best = levels;
  return best;
}

Result<std::vector<int>> choose_block_levels(std::span<const LayerPlan> plans, int threads, std::size_t memory_bytes) {
  std::vector<int> chosen;
  for (const LayerPlan& plan : plans)
    if (const auto levels = widest_fit(plan, threads, memory_bytes)) chosen.push_back(*levels);
  if (chosen.size() == plans.size()) return chosen;

  const auto enough = [&](int workers) {
    std::size_t most = 0;
    for (const LayerPlan& plan : plans) most = std::max(most, enough_memory(plan, workers));
    return most;
  };
  const auto fit_all = [&](int workers) {
    return std::ranges::all_of(plans, [&](const LayerPlan& plan) { return widest_fit(plan, workers, memory_bytes).has_value(); });
  };
  const auto greediest = std::ranges::max_element(plans, {}, [&](const LayerPlan& plan) { return enough_memory(plan, threads); });
  std::string message = "`memory` " + mebibytes(memory_bytes) + " is too little for layer '" + greediest->info.name + "' with " +
                        std::to_string(threads) + (threads == 1 ? " thread" : " threads") + "; it needs `memory` " +
                        mebibytes(enough(threads));
  int fewer = threads - 1;
  while (fewer >= 1 && !fit_all(fewer)) --fewer;
  if (fewer >= 1) message += ", or `threads` " + std::to_string(fewer);
  if (fewer < 1 && threads > 1) message += ", or at least `memory` " + mebibytes(enough(1)) + " with `threads` 1";
  return fail(ErrorCode::kUsage, message);
}

Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes) {
  VT_ASSIGN(const std::vector<int> chosen, choose_block_levels(std::span(&plan, 1), threads, memory_bytes));
  return chosen.front();
}

}  // namespace vt::pipeline
