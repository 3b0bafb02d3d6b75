#include "builder/encode/bc6h_encoder.h"

#include <cstdint>

#include "builder/encode/bc6h_block.h"
#include "builder/encode/block_batches.h"
#include "store/bc6h_table.h"

// Vectors without a compile-time size cannot be members of structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bc6h_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bc6h_fit-inl.h"
#include "builder/encode/bptc_partitions-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// What cannot be stored becomes what can: above infinity are NaN and all negative numbers.
HWY_INLINE F half_code(U half) {
  const U infinity = bits(0x7C00);
  U code = hn::IfThenElse(hn::Eq(half, infinity), bits(0x7BFF), half);
  const auto is_outside = hn::Gt(hn::BitCast(IntTag(), half), hn::BitCast(IntTag(), infinity));
  code = hn::IfThenZeroElse(hn::RebindMask(UintTag(), is_outside), code);
  return hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), code));
}

HWY_INLINE void load_texels(const std::uint8_t* rows, std::size_t pitch, Texels<3>& texels) {
  HWY_ALIGN_MAX std::uint32_t gathered[kMaxLanes];
  for (std::size_t y = 0; y < 4; ++y) {
    for (std::size_t x = 0; x < 4; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
          const std::uint8_t* at = rows + y * pitch + (lane * 4 + x) * 8 + c * 2;
          gathered[lane] = at[0] | static_cast<std::uint32_t>(at[1]) << 8U;
        }
        texels.set(y * 4 + x, static_cast<int>(c), half_code(hn::Load(UintTag(), gathered)));
      }
    }
  }
}

// A vector of Bc6hChoice, and the squared error of each.
struct Choices {
  F error;
  U mode;
  U partition;
  HalfEnd ends[4];
  U indices[2];
};

HWY_INLINE void keep_better(Choices& best, const Choices& other) {
  const FloatMask better = hn::Lt(other.error, best.error);
  best.error = hn::Min(other.error, best.error);
  best.mode = select(better, other.mode, best.mode);
  best.partition = select(better, other.partition, best.partition);
  for (int end = 0; end < 4; ++end) best.ends[end] = select(better, other.ends[end], best.ends[end]);
  for (int half = 0; half < 2; ++half) best.indices[half] = select(better, other.indices[half], best.indices[half]);
}

HWY_INLINE void write_blocks(const Choices& choices, std::uint8_t* blocks) {
  const UintTag u;
  HWY_ALIGN_MAX std::uint32_t mode[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t partition[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t ends[4][3][kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t indices[2][kMaxLanes];
  hn::Store(choices.mode, u, mode);
  hn::Store(choices.partition, u, partition);
  for (std::size_t end = 0; end < 4; ++end)
    for (std::size_t k = 0; k < 3; ++k) hn::Store(integer_bits(choices.ends[end].code.c[k]), u, ends[end][k]);
  for (std::size_t half = 0; half < 2; ++half) hn::Store(choices.indices[half], u, indices[half]);
  for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
    Bc6hChoice choice;
    choice.mode = mode[lane];
    choice.partition = partition[lane];
    for (std::size_t end = 0; end < 4; ++end)
      for (std::size_t k = 0; k < 3; ++k) choice.ends[end][k] = ends[end][k][lane];
    choice.indices = indices[0][lane] | std::uint64_t{indices[1][lane]} << 32U;
    write_bc6h_block(choice, std::span<std::byte, 16>(reinterpret_cast<std::byte*>(blocks) + lane * 16, 16));
  }
}

// The modes of one subset, finest first: row of store::kBc6hModes, bits of the base, bits of the difference.
struct OneSubsetMode {
  std::uint32_t row;
  int base_bits;
  int delta_bits;
};
constexpr OneSubsetMode kOneSubsetModes[3] = {{13, 16, 4}, {12, 12, 8}, {11, 11, 9}};

// The line `kept` in the finest mode that holds its two ends; `fitted` is the line before it was moved.
HWY_INLINE Choices one_subset_choice(const Line<3>& fitted, const Line<3>& kept, const Texels<3>& texels) {
  Choices choices;
  choices.mode = bits(10);
  choices.partition = bits(0);
  HalfEnd end0 = half_end(kept.end0, 10), end1 = half_end(kept.end1, 10);
  for (int m = 2; m >= 0; --m) {
    const OneSubsetMode& mode = kOneSubsetModes[m];
    const HalfEnd finer0 = half_end(kept.end0, mode.base_bits), finer1 = half_end(kept.end1, mode.base_bits);
    F difference = zero();
    for (int k = 0; k < 3; ++k) difference = hn::Max(difference, hn::Abs(hn::Sub(finer0.code.c[k], finer1.code.c[k])));
    const FloatMask fits = hn::Lt(difference, constant(static_cast<float>(1 << (mode.delta_bits - 1))));
    choices.mode = select(fits, bits(mode.row), choices.mode);
    end0 = select(fits, finer0, end0);
    end1 = select(fits, finer1, end1);
  }
  choices.ends[0] = choices.ends[2] = end0;
  choices.ends[1] = choices.ends[3] = end1;
  choices.error = evaluate_halves(end0, end1, fitted, kept, 4, texels, WholeBlock(), choices.indices);
  return choices;
}

HWY_NOINLINE Choices one_subset(const Texels<3>& texels, int passes) {
  const Moments<3> m = moments_of(texels, WholeBlock());
  Line<3> line = extremes(texels, WholeBlock(), m);
  Choices best;
  for (int pass = 0; pass < passes; ++pass) {
    line = refined(line, 4, texels, WholeBlock(), m).line;
    const Choices candidate = one_subset_choice(line, with_light_kept(line, 4, texels, WholeBlock()), texels);
    if (pass == 0) {
      best = candidate;
    } else {
      keep_better(best, candidate);
    }
  }
  return best;
}

// Modes of two subsets, the finest first: rows of store::kBc6hModes. The last one holds any ends.
constexpr std::uint32_t kTwoSubsetModes[10] = {2, 3, 4, 0, 5, 6, 7, 8, 1, 9};

// The lines of both subsets in the finest mode whose differences hold all four ends, whatever their order.
HWY_NOINLINE Choices two_subsets(const Texels<3>& texels, U partition, int passes) {
  Subset subsets[2];
  subsets_of(partition, subsets);
  Line<3> fitted[2], kept[2];
  for (int s = 0; s < 2; ++s) {
    const Moments<3> m = moments_of(texels, subsets[s]);
    fitted[s] = extremes(texels, subsets[s], m);
    for (int pass = 0; pass < passes; ++pass) fitted[s] = refined(fitted[s], 3, texels, subsets[s], m).line;
    kept[s] = with_light_kept(fitted[s], 3, texels, subsets[s]);
  }

  Choices choices;
  choices.partition = partition;
  for (int m = 9; m >= 0; --m) {
    const store::Bc6hMode& mode = store::kBc6hModes[kTwoSubsetModes[m]];
    HalfEnd ends[4];
    for (int end = 0; end < 4; ++end) ends[end] = half_end(end % 2 == 0 ? kept[end / 2].end0 : kept[end / 2].end1, mode.base_bits);
    FloatMask fits = hn::Eq(zero(), zero());
    for (int k = 0; mode.transformed && k < 3; ++k) {
      F low = ends[0].code.c[k], high = low;
      for (int end = 1; end < 4; ++end) {
        low = hn::Min(low, ends[end].code.c[k]);
        high = hn::Max(high, ends[end].code.c[k]);
      }
      fits =
          hn::And(fits, hn::Lt(hn::Sub(high, low), constant(static_cast<float>(1 << (mode.delta_bits[static_cast<std::size_t>(k)] - 1)))));
    }
    choices.mode = m == 9 ? bits(kTwoSubsetModes[m]) : select(fits, bits(kTwoSubsetModes[m]), choices.mode);
    for (int end = 0; end < 4; ++end) choices.ends[end] = m == 9 ? ends[end] : select(fits, ends[end], choices.ends[end]);
  }
  choices.error = zero();
  choices.indices[0] = choices.indices[1] = bits(0);
  for (int s = 0; s < 2; ++s) {
    U indices[2];
    choices.error = hn::Add(
        choices.error, evaluate_halves(choices.ends[2 * s], choices.ends[2 * s + 1], fitted[s], kept[s], 3, texels, subsets[s], indices));
    for (int half = 0; half < 2; ++half) choices.indices[half] = hn::Or(choices.indices[half], indices[half]);
  }
  return choices;
}

constexpr int kMostTrials = 6;

// As many blocks as there are lanes, side by side. `blocks` takes 16 bytes of each.
HWY_INLINE void encode_batch(const std::uint8_t* rows, std::size_t pitch, Quality quality, std::uint8_t* blocks) {
  Texels<3> texels;
  load_texels(rows, pitch, texels);
  Choices best = one_subset(texels, quality == Quality::kFast ? 1 : 4);
  if (quality != Quality::kFast) {
    Ranking<kMostTrials> ranking;
    rank_two_subsets(Terms<3>(texels), 32, ranking);
    const int trials = quality == Quality::kBest ? kMostTrials : 1;
    for (int k = 0; k < trials; ++k) keep_better(best, two_subsets(texels, ranking.partition[k], 2));
  }
  write_blocks(best, blocks);
}

void encode_halves(const BlockJob& job) {
  for_each_batch<kMaxLanes, 8, 16>(
      job, [&job](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) { encode_batch(rows, pitch, job.quality, blocks); });
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_halves);

void encode_bc6h_image(std::span<const std::byte> rgba16f, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                       Quality quality, std::span<std::byte> blocks) {
  HWY_DYNAMIC_DISPATCH(encode_halves)(block_job(rgba16f, width, height, row_pitch_bytes, 8, quality, blocks, 16));
}

}  // namespace vt::encode
#endif  // HWY_ONCE
