// Which partitions of a BC7 or BC6H block are worth a fit: all of them are ranked by what lines through their
// subsets would leave, without quantisation. One block per SIMD lane. Included once per CPU target.
#if defined(VT_BUILDER_ENCODE_BPTC_PARTITIONS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BPTC_PARTITIONS_INL_H
#undef VT_BUILDER_ENCODE_BPTC_PARTITIONS_INL_H
#else
#define VT_BUILDER_ENCODE_BPTC_PARTITIONS_INL_H
#endif

#include <array>

#include "builder/encode/bptc/bptc_lanes-inl.h"
#include "store/texel/bptc_table.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// Texels of subset 1 in bits 0-15 and of subset 2 in bits 16-31, for 64 partitions into two subsets and then
// 64 into three.
constexpr std::array<std::uint32_t, 128> kSubsetMasks = [] {
  std::array<std::uint32_t, 128> masks{};
  for (std::size_t p = 0; p < 64; ++p) {
    masks[p] = store::kTwoSubsets[p];
    for (std::size_t i = 0; i < 16; ++i) {
      const std::size_t subset = store::bptc_subset(3, p, i);
      if (subset != 0) masks[64 + p] |= 1U << (i + 16 * (subset - 1));
    }
  }
  return masks;
}();

// The partitions of each block with the least errors, best first.
template <int kCount>
struct Ranking {
  F error[kCount];
  U partition[kCount];

  HWY_INLINE Ranking() {
    for (int k = 0; k < kCount; ++k) {
      error[k] = constant(kNoError);
      partition[k] = bits(0);
    }
  }
  // Behind those of the same error; those behind it move on by one.
  HWY_INLINE void add(F new_error, std::uint32_t number) {
    U new_partition = bits(number);
    FloatMask moves = nowhere();
    for (int k = 0; k < kCount; ++k) {
      moves = hn::Or(moves, hn::Lt(new_error, error[k]));
      const F last_error = error[k];
      const U last_partition = partition[k];
      error[k] = hn::IfThenElse(moves, new_error, last_error);
      partition[k] = select(moves, new_partition, last_partition);
      new_error = hn::IfThenElse(moves, last_error, new_error);
      new_partition = select(moves, last_partition, new_partition);
    }
  }
};

// Sums of the channels and of their products over some texels.
template <int kChannels>
struct Sums {
  static constexpr int kProducts = kChannels * (kChannels + 1) / 2;
  F v[kChannels + kProducts];

  // What a line through `count` texels would leave.
  HWY_INLINE F off_line(int count) const {
    const F inverse = constant(1.0F / static_cast<float>(count));
    Color<kChannels> rows[kChannels];
    int product = kChannels;
    for (int c = 0; c < kChannels; ++c) {
      for (int d = c; d < kChannels; ++d) {
        rows[c].c[d] = hn::Sub(v[product], hn::Mul(hn::Mul(v[c], v[d]), inverse));
        rows[d].c[c] = rows[c].c[d];
        ++product;
      }
    }
    return off_axis(rows);
  }
};

// The sums' terms for each texel, less the rounded mean of the block. Those of 8-bit texels are integers that
// floats add exactly.
template <int kChannels>
struct Terms {
  static constexpr int kTerms = kChannels + Sums<kChannels>::kProducts;
  HWY_ALIGN_MAX float v[16][kTerms][kMaxLanes];
  Sums<kChannels> total;

  HWY_INLINE explicit Terms(const Texels<kChannels>& texels) {
    Color<kChannels> mean;
    for (int c = 0; c < kChannels; ++c) {
      mean.c[c] = zero();
      for (std::size_t i = 0; i < 16; ++i) mean.c[c] = hn::Add(mean.c[c], texels.get(i).c[c]);
      mean.c[c] = rounded(hn::Mul(mean.c[c], constant(1.0F / 16.0F)));
    }
    for (F& sum : total.v) sum = zero();
    for (std::size_t i = 0; i < 16; ++i) {
      F terms[kTerms];
      const Color<kChannels> texel = texels.get(i);
      for (int c = 0; c < kChannels; ++c) terms[c] = hn::Sub(texel.c[c], mean.c[c]);
      int product = kChannels;
      for (int c = 0; c < kChannels; ++c)
        for (int d = c; d < kChannels; ++d) terms[product++] = hn::Mul(terms[c], terms[d]);
      for (int t = 0; t < kTerms; ++t) {
        hn::Store(terms[t], FloatTag(), v[i][t]);
        total.v[t] = hn::Add(total.v[t], terms[t]);
      }
    }
  }

  HWY_INLINE Sums<kChannels> of(std::uint32_t mask) const {
    Sums<kChannels> sums;
    for (F& sum : sums.v) sum = zero();
    for (std::size_t i = 0; i < 16; ++i)
      if ((mask >> i & 1U) != 0)
        for (int t = 0; t < kTerms; ++t) sums.v[t] = hn::Add(sums.v[t], hn::Load(FloatTag(), v[i][t]));
    return sums;
  }
};

template <int kChannels>
HWY_INLINE Sums<kChannels> difference(const Sums<kChannels>& p, const Sums<kChannels>& q) {
  Sums<kChannels> result;
  for (int t = 0; t < Terms<kChannels>::kTerms; ++t) result.v[t] = hn::Sub(p.v[t], q.v[t]);
  return result;
}

// Among the first `partitions`.
template <int kChannels, int kCount>
HWY_NOINLINE void rank_two_subsets(const Terms<kChannels>& terms, std::uint32_t partitions, Ranking<kCount>& ranking) {
  for (std::uint32_t p = 0; p < partitions; ++p) {
    const std::uint32_t mask = kSubsetMasks[p];
    const int count = hwy::PopCount(mask);
    const Sums<kChannels> second = terms.of(mask);
    ranking.add(hn::Add(difference(terms.total, second).off_line(16 - count), second.off_line(count)), p);
  }
}

// Among the first 16, and among all.
template <int kChannels, int kCount>
HWY_NOINLINE void rank_three_subsets(const Terms<kChannels>& terms, Ranking<kCount>& ranking16, Ranking<kCount>& ranking64) {
  for (std::uint32_t p = 0; p < 64; ++p) {
    const std::uint32_t second_mask = kSubsetMasks[64 + p] & 0xFFFFU;
    const std::uint32_t third_mask = kSubsetMasks[64 + p] >> 16U;
    const int second_count = hwy::PopCount(second_mask);
    const int third_count = hwy::PopCount(third_mask);
    const Sums<kChannels> second = terms.of(second_mask);
    const Sums<kChannels> third = terms.of(third_mask);
    const F first_error = difference(difference(terms.total, second), third).off_line(16 - second_count - third_count);
    const F error = hn::Add(hn::Add(first_error, second.off_line(second_count)), third.off_line(third_count));
    if (p < 16) ranking16.add(error, p);
    ranking64.add(error, p);
  }
}

// Masks of the subsets of a partition that may differ from block to block.
template <int kSubsets>
HWY_INLINE void subsets_of(U partition, Subset (&subsets)[kSubsets]) {
  const UintTag u;
  const U index = kSubsets == 3 ? hn::Add(partition, bits(64)) : partition;
  const U masks = hn::GatherIndex(u, kSubsetMasks.data(), hn::BitCast(IntTag(), index));
  const U second = hn::And(masks, bits(0xFFFF));
  const U third = hn::ShiftRight<16>(masks);
  subsets[0].mask = hn::Xor(hn::Or(second, third), bits(0xFFFF));
  subsets[1].mask = second;
  if constexpr (kSubsets == 3) subsets[2].mask = third;
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
