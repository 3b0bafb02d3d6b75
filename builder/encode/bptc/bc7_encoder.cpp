#include "builder/encode/bptc/bc7_encoder.h"

#include <cstdint>

#include "builder/encode/block_batches.h"

// Vectors without a compile-time size cannot be members of structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bptc/bc7_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bptc/bc7_modes-inl.h"

// The method: every block in mode 6, and in the other modes that its alpha and the quality allow; the least
// exact error wins. Each fit starts on the principal axis and is refined by least squares between roundings
// to the mode's codes (bc7_fit-inl.h). Partitions are ranked by what lines through their subsets would leave
// (bptc_partitions-inl.h), and the first few are fitted.
HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// Four texels of a row in the four bytes of a lane, leftmost lowest, for each channel.
struct PackedRow {
  U channel[4];
};

HWY_INLINE PackedRow load_row(const std::uint8_t* row) {
#if HWY_TARGET == HWY_SCALAR
  PackedRow packed;
  for (std::size_t c = 0; c < 4; ++c)
    packed.channel[c] = bits(row[c] | static_cast<std::uint32_t>(row[4 + c]) << 8U | static_cast<std::uint32_t>(row[8 + c]) << 16U |
                             static_cast<std::uint32_t>(row[12 + c]) << 24U);
  return packed;
#else
  // Taking the channels apart leaves four neighbouring texels in each 32-bit lane: that is one block per
  // lane.
  const hn::Repartition<std::uint8_t, FloatTag> bytes;
  hn::Vec<decltype(bytes)> r, g, b, a;
  hn::LoadInterleaved4(bytes, row, r, g, b, a);
  const UintTag u;
  return {{hn::BitCast(u, r), hn::BitCast(u, g), hn::BitCast(u, b), hn::BitCast(u, a)}};
#endif
}

// The texels of one batch, and what they are like.
struct Batch {
  Texels<4> rgba;
  FloatMask is_flat;    // one colour
  FloatMask is_opaque;  // alpha 255 throughout
};

HWY_INLINE void load_batch(const std::uint8_t* rows, std::size_t pitch, Batch& batch) {
  const IntTag i32;
  Color<4> low, high;
  for (int c = 0; c < 4; ++c) low.c[c] = constant(255.0F), high.c[c] = zero();
  for (std::size_t y = 0; y < 4; ++y) {
    PackedRow row = load_row(rows + y * pitch);
    for (std::size_t x = 0; x < 4; ++x) {
      for (int c = 0; c < 4; ++c) {
        const F value = hn::ConvertTo(FloatTag(), hn::BitCast(i32, hn::And(row.channel[c], bits(0xFF))));
        row.channel[c] = hn::ShiftRight<8>(row.channel[c]);
        batch.rgba.set(y * 4 + x, c, value);
        low.c[c] = hn::Min(low.c[c], value);
        high.c[c] = hn::Max(high.c[c], value);
      }
    }
  }
  F spread = zero();
  for (int c = 0; c < 4; ++c) spread = hn::Add(spread, hn::Sub(high.c[c], low.c[c]));
  batch.is_flat = hn::Eq(spread, zero());
  batch.is_opaque = hn::Eq(low.c[3], constant(255.0F));
}

HWY_INLINE void write_blocks(const Choices& choices, std::uint8_t* blocks) {
  const UintTag u;
  HWY_ALIGN_MAX std::uint32_t head[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t ends[6][kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t indices[4][kMaxLanes];
  hn::Store(choices.head, u, head);
  for (std::size_t end = 0; end < 6; ++end) hn::Store(choices.ends[end], u, ends[end]);
  for (std::size_t half = 0; half < 2; ++half) {
    hn::Store(choices.indices[half], u, indices[half]);
    hn::Store(choices.alpha_indices[half], u, indices[2 + half]);
  }
  for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
    Bc7Choice choice;
    choice.head = head[lane];
    for (std::size_t end = 0; end < 6; ++end) choice.ends[end] = ends[end][lane];
    choice.indices = indices[0][lane] | std::uint64_t{indices[1][lane]} << 32U;
    choice.alpha_indices = indices[2][lane] | std::uint64_t{indices[3][lane]} << 32U;
    write_bc7_block(choice, std::span<std::byte, 16>(reinterpret_cast<std::byte*>(blocks) + lane * 16, 16));
  }
}

// The candidate counts only for the blocks that may take it.
HWY_INLINE void compete(Choices& best, Choices candidate, FloatMask allowed) {
  candidate.error = hn::IfThenElse(allowed, candidate.error, constant(kNoError));
  keep_better(best, candidate);
}

// How many of the ranked partitions are fitted. More of them were measured on six aerial images: for kNormal
// a third in mode 1 gains 0.1 dB for 15 % of the time, a second in mode 3 gains 0.05 dB.
constexpr int kMostTrials = 8;
constexpr int kMostTrialsOfThree = 4;

// For blocks with alpha: alpha apart, and two subsets.
HWY_NOINLINE void try_alpha_modes(const Batch& batch, Quality quality, Choices& best) {
  const FloatMask allowed = hn::Not(batch.is_opaque);
  const int passes = quality == Quality::kBest ? 4 : 2;
  compete(best, mode5(batch.rgba, 0, passes), allowed);
  if (quality == Quality::kFast) return;

  Ranking<kMostTrials> ranking;
  rank_two_subsets(Terms<4>(batch.rgba), 64, ranking);
  const int trials = quality == Quality::kBest ? kMostTrials : 1;
  for (int k = 0; k < trials; ++k)
    compete(best, partitioned<7, CodeFormat<5, 2>, 2, 2>(batch.rgba, ranking.partition[k], nowhere(), 2), allowed);
  if (quality == Quality::kNormal) return;

  for (std::uint32_t rotation = 0; rotation < 4; ++rotation) {
    if (rotation != 0) compete(best, mode5(batch.rgba, rotation, passes), allowed);
    for (std::uint32_t selection = 0; selection < 2; ++selection) compete(best, mode4(batch.rgba, rotation, selection, passes), allowed);
  }
}

// For blocks without alpha: two and three subsets of colours, and one colour channel apart.
HWY_NOINLINE void try_opaque_modes(const Batch& batch, Quality quality, Choices& best) {
  Texels<3> texels;
  for (std::size_t i = 0; i < 16; ++i)
    for (int c = 0; c < 3; ++c) texels.set(i, c, batch.rgba.get(i).c[c]);
  const Terms<3> terms(texels);
  Ranking<kMostTrials> ranking;
  rank_two_subsets(terms, 64, ranking);
  const int trials1 = quality == Quality::kBest ? kMostTrials : 2;
  const int trials3 = quality == Quality::kBest ? kMostTrials : 1;
  for (int k = 0; k < trials1; ++k)
    compete(best, partitioned<1, CodeFormat<6, 1>, 3, 2>(texels, ranking.partition[k], nowhere(), 2), batch.is_opaque);
  for (int k = 0; k < trials3; ++k)
    compete(best, partitioned<3, CodeFormat<7, 2>, 2, 2>(texels, ranking.partition[k], nowhere(), 2), batch.is_opaque);
  if (quality == Quality::kNormal) return;

  // Mode 0 knows the first 16 partitions only.
  Ranking<kMostTrialsOfThree> ranking16, ranking64;
  rank_three_subsets(terms, ranking16, ranking64);
  for (int k = 0; k < kMostTrialsOfThree; ++k) {
    compete(best, partitioned<0, CodeFormat<4, 2>, 3, 3>(texels, ranking16.partition[k], nowhere(), 2), batch.is_opaque);
    compete(best, partitioned<2, CodeFormat<5, 0>, 2, 3>(texels, ranking64.partition[k], nowhere(), 2), batch.is_opaque);
  }
  // With rotation 0, alpha apart, only bits would be lost.
  for (std::uint32_t rotation = 1; rotation < 4; ++rotation) {
    compete(best, mode5(batch.rgba, rotation, 2), batch.is_opaque);
    for (std::uint32_t selection = 0; selection < 2; ++selection) compete(best, mode4(batch.rgba, rotation, selection, 2), batch.is_opaque);
  }
}

// As many blocks as there are lanes, side by side. `blocks` takes 16 bytes of each.
HWY_INLINE void encode_batch(const std::uint8_t* rows, std::size_t pitch, Quality quality, std::uint8_t* blocks) {
  Batch batch;
  load_batch(rows, pitch, batch);
  Choices best = mode6(batch.rgba, batch.is_opaque, quality == Quality::kFast ? 2 : 4);
  if (!hn::AllTrue(FloatTag(), batch.is_opaque)) try_alpha_modes(batch, quality, best);
  if (quality != Quality::kFast && !hn::AllFalse(FloatTag(), batch.is_opaque)) try_opaque_modes(batch, quality, best);

  U color = bits(0);
  for (int c = 4; c-- > 0;) color = hn::Or(hn::ShiftLeft<8>(color), integer_bits(batch.rgba.get(0).c[c]));
  best.head = select(batch.is_flat, bits(Bc7Choice::kSolid), best.head);
  best.ends[0] = select(batch.is_flat, color, best.ends[0]);
  write_blocks(best, blocks);
}

void encode_rgba(const BlockImage& image) {
  for_each_batch<kMaxLanes, 4, 16>(image, [&image](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    encode_batch(rows, pitch, image.quality, blocks);
  });
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_rgba);

void encode_bc7_image(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  HWY_DYNAMIC_DISPATCH(encode_rgba)(block_image(rgba, width, height, row_pitch_bytes, 4, quality, blocks, 16));
}

}  // namespace vt::encode
#endif  // HWY_ONCE
