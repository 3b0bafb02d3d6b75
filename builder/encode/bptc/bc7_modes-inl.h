// What each mode of BC7 makes of a batch of blocks, one per SIMD lane. Included once per CPU target.
#if defined(VT_BUILDER_ENCODE_BC7_MODES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC7_MODES_INL_H
#undef VT_BUILDER_ENCODE_BC7_MODES_INL_H
#else
#define VT_BUILDER_ENCODE_BC7_MODES_INL_H
#endif

#include "builder/encode/bptc/bc7_block.h"
#include "builder/encode/bptc/bc7_fit-inl.h"
#include "builder/encode/bptc/bptc_partitions-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// A vector of Bc7Choice, and the exact squared error of each.
struct Choices {
  F error;
  U head;
  U ends[6];
  U indices[2];
  U alpha_indices[2];

  HWY_INLINE Choices(std::uint32_t mode, U partition) {
    error = zero();
    head = hn::Or(bits(mode), hn::ShiftLeft<Bc7Choice::kPartitionShift>(partition));
    for (U& end : ends) end = bits(0);
    for (int half = 0; half < 2; ++half) indices[half] = alpha_indices[half] = bits(0);
  }

  template <int kChannels>
  HWY_INLINE void put_subset(int subset, const SubsetCode<kChannels>& code) {
    error = hn::Add(error, code.error);
    head = hn::Or(
        head, hn::Shl(code.lowest, bits(static_cast<std::uint32_t>(Bc7Choice::kLowestBitShift) + 2U * static_cast<std::uint32_t>(subset))));
    ends[2 * subset] = code.end0.code;
    ends[2 * subset + 1] = code.end1.code;
    for (int half = 0; half < 2; ++half) indices[half] = hn::Or(indices[half], code.indices[half]);
  }
};

HWY_INLINE void keep_better(Choices& best, const Choices& other) {
  const FloatMask better = hn::Lt(other.error, best.error);
  best.error = hn::Min(other.error, best.error);
  best.head = select(better, other.head, best.head);
  for (int end = 0; end < 6; ++end) best.ends[end] = select(better, other.ends[end], best.ends[end]);
  for (int half = 0; half < 2; ++half) {
    best.indices[half] = select(better, other.indices[half], best.indices[half]);
    best.alpha_indices[half] = select(better, other.alpha_indices[half], best.alpha_indices[half]);
  }
}

HWY_NOINLINE Choices mode6(const Texels<4>& texels, FloatMask is_opaque, int passes) {
  Choices choices(6, bits(0));
  choices.put_subset(0, fitted<CodeFormat<7, 2>, 4>(texels, WholeBlock(), is_opaque, passes));
  return choices;
}

// A mode of several subsets in a partition that may differ from block to block. `ones`: where all lowest bits
// must be 1.
template <int kMode, class Format, int kIndexBits, int kSubsets, int kChannels>
HWY_NOINLINE Choices partitioned(const Texels<kChannels>& texels, U partition, FloatMask ones, int passes) {
  Subset subsets[kSubsets];
  subsets_of(partition, subsets);
  Choices choices(kMode, partition);
  for (int s = 0; s < kSubsets; ++s) choices.put_subset(s, fitted<Format, kIndexBits>(texels, subsets[s], ones, passes));
  return choices;
}

// A mode with indices of their own for one channel: alpha, or the one that `rotation` (1 red, 2 green, 3
// blue) exchanges with it.
template <int kMode, class ColorFormat, int kColorIndexBits, class AlphaFormat, int kAlphaIndexBits>
HWY_NOINLINE Choices separated(const Texels<4>& texels, std::uint32_t rotation, std::uint32_t selection, int passes) {
  Texels<3> color;
  Texels<1> alpha;
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<4> texel = texels.get(i);
    for (int c = 0; c < 3; ++c) color.set(i, c, c + 1 == static_cast<int>(rotation) ? texel.c[3] : texel.c[c]);
    alpha.set(i, 0, texel.c[(rotation + 3) % 4]);
  }
  Choices choices(kMode, bits(0));
  choices.head = hn::Or(choices.head, bits(rotation << Bc7Choice::kRotationShift | selection << Bc7Choice::kSelectionShift));
  choices.put_subset(0, fitted<ColorFormat, kColorIndexBits>(color, WholeBlock(), nowhere(), passes));
  const SubsetCode<1> own = fitted<AlphaFormat, kAlphaIndexBits>(alpha, WholeBlock(), nowhere(), passes);
  choices.error = hn::Add(choices.error, own.error);
  choices.ends[0] = hn::Or(choices.ends[0], hn::ShiftLeft<24>(own.end0.code));
  choices.ends[1] = hn::Or(choices.ends[1], hn::ShiftLeft<24>(own.end1.code));
  for (int half = 0; half < 2; ++half) choices.alpha_indices[half] = own.indices[half];
  return choices;
}

HWY_INLINE Choices mode4(const Texels<4>& texels, std::uint32_t rotation, std::uint32_t selection, int passes) {
  if (selection == 0) return separated<4, CodeFormat<5, 0>, 2, CodeFormat<6, 0>, 3>(texels, rotation, 0, passes);
  return separated<4, CodeFormat<5, 0>, 3, CodeFormat<6, 0>, 2>(texels, rotation, 1, passes);
}
HWY_INLINE Choices mode5(const Texels<4>& texels, std::uint32_t rotation, int passes) {
  return separated<5, CodeFormat<7, 0>, 2, CodeFormat<8, 0>, 2>(texels, rotation, 0, passes);
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
