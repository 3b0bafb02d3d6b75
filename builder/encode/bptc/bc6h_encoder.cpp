#include "builder/encode/bptc/bc6h_encoder.h"

#include <cstdint>

#include "builder/encode/block_batches.h"
#include "builder/encode/bptc/bc6h_block.h"
#include "store/texel/bc6h_table.h"

// Vectors without a compile-time size cannot be members of structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bptc/bc6h_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bptc/bc6h_fit-inl.h"
#include "builder/encode/bptc/bptc_partitions-inl.h"

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

// A vector of Bc6hChoice, and what each costs.
struct Choices {
  F cost;
  U mode;
  U partition;
  HalfEnd ends[4];
  U indices[2];
};

HWY_INLINE void keep_better(Choices& best, const Choices& other) {
  const FloatMask better = hn::Lt(other.cost, best.cost);
  best.cost = hn::Min(other.cost, best.cost);
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
  F weights[16];
  pick_indices(end0, end1, fitted, kept, 4, texels, WholeBlock(), choices.indices, weights);
  const SubsetLight wanted = light_of_subset(weights, texels, WholeBlock());
  choices.cost = added(zero(), channel_costs(end0.value, end1.value, weights, wanted, kFreeLight, texels, WholeBlock()));
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
  choices.cost = zero();
  choices.indices[0] = choices.indices[1] = bits(0);
  for (int s = 0; s < 2; ++s) {
    const HalfEnd& end0 = choices.ends[2 * s];
    const HalfEnd& end1 = choices.ends[2 * s + 1];
    U indices[2];
    F weights[16];
    pick_indices(end0, end1, fitted[s], kept[s], 3, texels, subsets[s], indices, weights);
    const SubsetLight wanted = light_of_subset(weights, texels, subsets[s]);
    choices.cost = added(choices.cost, channel_costs(end0.value, end1.value, weights, wanted, kFreeLight, texels, subsets[s]));
    for (int half = 0; half < 2; ++half) choices.indices[half] = hn::Or(choices.indices[half], indices[half]);
  }
  return choices;
}

// How the codes of each lane's mode are made.
struct Coding {
  FloatMask one_subset;
  FloatMask is_exact;  // codes of 16 bits are the numbers themselves
  F step;              // numbers from one code to the next
  F last;              // code
  Color<3> most;       // codes from the least to the greatest end of a channel, and one more

  HWY_INLINE explicit Coding(U mode) {
    one_subset = is_exact = nowhere();
    step = last = zero();
    for (int k = 0; k < 3; ++k) most.c[k] = constant(65536.0F);
    for (std::uint32_t row = 0; row < store::kBc6hModes.size(); ++row) {
      const store::Bc6hMode& info = store::kBc6hModes[row];
      const FloatMask is_row = hn::RebindMask(FloatTag(), hn::Eq(mode, bits(row)));
      const auto codes = static_cast<float>(1U << info.base_bits);
      if (info.subsets == 1) one_subset = hn::Or(one_subset, is_row);
      if (info.base_bits == 16) is_exact = hn::Or(is_exact, is_row);
      step = hn::IfThenElse(is_row, constant(65536.0F / codes), step);
      last = hn::IfThenElse(is_row, constant(codes - 1.0F), last);
      for (int k = 0; info.transformed && k < 3; ++k)
        most.c[k] =
            hn::IfThenElse(is_row, constant(static_cast<float>(1 << (info.delta_bits[static_cast<std::size_t>(k)] - 1))), most.c[k]);
    }
  }

  // As half_end() has it.
  HWY_INLINE F number(F code) const {
    F value = hn::Mul(hn::Add(code, constant(0.5F)), step);
    value = hn::IfThenElse(hn::Eq(code, zero()), zero(), value);
    value = hn::IfThenElse(hn::Eq(code, last), constant(65535.0F), value);
    return hn::IfThenElse(is_exact, code, value);
  }
};

// Single steps of single codes, as long as they cost less, two rounds of them; the indices stay. What the
// modes' rounding of the ends took from the light comes back here.
HWY_NOINLINE void step_ends(const Texels<3>& texels, Choices& choices) {
  const Coding coding(choices.mode);
  const U one_subset = hn::VecFromMask(UintTag(), hn::RebindMask(UintTag(), coding.one_subset));
  Subset subsets[2];
  subsets_of(choices.partition, subsets);
  // The first of one subset has all texels, the second none.
  subsets[0].mask = hn::Or(subsets[0].mask, hn::And(one_subset, bits(0xFFFF)));
  subsets[1].mask = hn::AndNot(one_subset, subsets[1].mask);
  const F last_index = hn::IfThenElse(coding.one_subset, constant(64.0F / 15.0F), constant(64.0F / 7.0F));
  F weights[16];
  for (std::size_t i = 0; i < 16; ++i) {
    const U index = hn::And(hn::ShiftRightSame(choices.indices[i / 8], static_cast<int>(i % 8 * 4)), bits(15));
    weights[i] = rounded(hn::Mul(hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), index)), last_index));
  }
  SubsetLight wanted[2];
  Color<3> best[2];
  for (int s = 0; s < 2; ++s) {
    wanted[s] = light_of_subset(weights, texels, subsets[s]);
    best[s] = channel_costs(choices.ends[2 * s].value, choices.ends[2 * s + 1].value, weights, wanted[s], 0.0F, texels, subsets[s]);
  }
  for (int round = 0; round < 2; ++round) {
    for (int s = 0; s < 2; ++s) {
      const HalfEnd start[2] = {choices.ends[2 * s], choices.ends[2 * s + 1]};
      HalfEnd kept[2] = {start[0], start[1]};
      for (int end = 0; end < 2; ++end) {
        for (const float step : {-1.0F, 1.0F}) {
          HalfEnd moved[2] = {start[0], start[1]};
          FloatMask is_possible[3];
          for (int k = 0; k < 3; ++k) {
            const F code = hn::Add(start[end].code.c[k], constant(step));
            moved[end].code.c[k] = code;
            moved[end].value.c[k] = coding.number(code);
            F low = hn::Min(moved[0].code.c[k], moved[1].code.c[k]);
            F high = hn::Max(moved[0].code.c[k], moved[1].code.c[k]);
            for (int other = 0; other < 2; ++other) {
              // With one subset the others are copies of these.
              const F there = hn::IfThenElse(coding.one_subset, low, choices.ends[2 - 2 * s + other].code.c[k]);
              low = hn::Min(low, there);
              high = hn::Max(high, there);
            }
            is_possible[k] =
                hn::And(hn::And(hn::Ge(code, zero()), hn::Le(code, coding.last)), hn::Lt(hn::Sub(high, low), coding.most.c[k]));
          }
          const Color<3> costs = channel_costs(moved[0].value, moved[1].value, weights, wanted[s], 0.0F, texels, subsets[s]);
          for (int k = 0; k < 3; ++k) {
            const FloatMask better = hn::And(is_possible[k], hn::Lt(costs.c[k], best[s].c[k]));
            best[s].c[k] = hn::IfThenElse(better, costs.c[k], best[s].c[k]);
            for (int e = 0; e < 2; ++e) {
              kept[e].code.c[k] = hn::IfThenElse(better, moved[e].code.c[k], kept[e].code.c[k]);
              kept[e].value.c[k] = hn::IfThenElse(better, moved[e].value.c[k], kept[e].value.c[k]);
            }
          }
        }
      }
      for (int e = 0; e < 2; ++e) choices.ends[2 * s + e] = kept[e];
      if (s == 0)
        for (int e = 0; e < 2; ++e) choices.ends[2 + e] = select(coding.one_subset, kept[e], choices.ends[2 + e]);
    }
  }
}

// All texels in the half nearest to their mean light: where light and darkness alternate so that no line
// follows, this at least keeps it.
HWY_NOINLINE Choices one_color(const Texels<3>& texels) {
  Color<3> mean;
  for (int k = 0; k < 3; ++k) {
    F sum = zero();
    for (std::size_t i = 0; i < 16; ++i) sum = hn::Add(sum, light(integer_bits(texels.get(i).c[k])));
    // The other way than light(); halves up.
    const U shifted = hn::BitCast(UintTag(), hn::Mul(sum, constant(0x1p-112F / 16.0F)));
    const U code = hn::ShiftRight<13>(hn::Add(shifted, bits(0x1000)));
    mean.c[k] = hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), code));
  }
  Choices choices;
  choices.mode = bits(13);
  choices.partition = choices.indices[0] = choices.indices[1] = bits(0);
  const HalfEnd end = half_end(mean, 16);
  for (HalfEnd& one : choices.ends) one = end;
  F weights[16];
  for (F& weight : weights) weight = zero();
  const SubsetLight wanted = light_of_subset(weights, texels, WholeBlock());
  choices.cost = added(zero(), channel_costs(end.value, end.value, weights, wanted, kFreeLight, texels, WholeBlock()));
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
  keep_better(best, one_color(texels));
  step_ends(texels, best);
  write_blocks(best, blocks);
}

void encode_halves(const BlockImage& image) {
  for_each_batch<kMaxLanes, 8, 16>(image, [&image](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    encode_batch(rows, pitch, image.quality, blocks);
  });
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_halves);

void encode_bc6h_image(std::span<const std::byte> rgba16f, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                       Quality quality, std::span<std::byte> blocks) {
  HWY_DYNAMIC_DISPATCH(encode_halves)(block_image(rgba16f, width, height, row_pitch_bytes, 8, quality, blocks, 16));
}

}  // namespace vt::encode
#endif  // HWY_ONCE
