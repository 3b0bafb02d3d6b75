// The best end points that this encoder finds for one subset of a BC7 block, in the codes of a mode: one
// block per SIMD lane. Included once per CPU target.
#if defined(VT_BUILDER_ENCODE_BC7_FIT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC7_FIT_INL_H
#undef VT_BUILDER_ENCODE_BC7_FIT_INL_H
#else
#define VT_BUILDER_ENCODE_BC7_FIT_INL_H
#endif

#include "builder/encode/bptc/bptc_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// Codes of one end point and what they decode to.
template <int kChannels>
struct Codes {
  Color<kChannels> value;  // 0 to 255
  U code;                  // 8 bits a channel, without the lowest shared bit
};

// How the codes of a mode are made: bits of a channel, and of lowest bits per subset (0, 1 for both ends, 2).
template <int kCodeBits, int kLowestBits>
struct CodeFormat {
  static constexpr int kTotalBits = kCodeBits + (kLowestBits != 0 ? 1 : 0);
  static constexpr int kSharedBits = kLowestBits;

  // The nearest code for each channel of a colour, with the given lowest bit (0 where the format has none).
  template <int kChannels>
  static HWY_INLINE Codes<kChannels> nearest(const Color<kChannels>& color, U lowest) {
    constexpr float kSteps = static_cast<float>((1 << kTotalBits) - 1) / 255.0F;
    const IntTag i32;
    Codes<kChannels> codes;
    codes.code = bits(0);
    const F bit = hn::ConvertTo(FloatTag(), hn::BitCast(i32, lowest));
    for (int c = 0; c < kChannels; ++c) {
      F step = hn::Mul(color.c[c], constant(kSteps));
      if constexpr (kLowestBits != 0) step = hn::Mul(hn::Sub(step, bit), constant(0.5F));
      const U code = integer_bits(rounded(clamped(step, 0.0F, static_cast<float>((1 << kCodeBits) - 1))));
      U total = code;
      if constexpr (kLowestBits != 0) total = hn::Or(hn::ShiftLeft<1>(code), lowest);
      if constexpr (kTotalBits < 8) total = hn::Or(hn::ShiftLeft<8 - kTotalBits>(total), hn::ShiftRight<2 * kTotalBits - 8>(total));
      codes.value.c[c] = hn::ConvertTo(FloatTag(), hn::BitCast(i32, total));
      codes.code = hn::Or(codes.code, hn::Shl(code, bits(static_cast<std::uint32_t>(8 * c))));
    }
    return codes;
  }
};

template <int kChannels>
HWY_INLINE Codes<kChannels> select(FloatMask mask, const Codes<kChannels>& yes, const Codes<kChannels>& no) {
  return {select(mask, yes.value, no.value), select(mask, yes.code, no.code)};
}

// A subset as a mode would store it.
template <int kChannels>
struct SubsetCode {
  Codes<kChannels> end0, end1;
  U lowest;      // lowest bit of end 0 in bit 0, of end 1 in bit 1
  U indices[2];  // of texels 0-7 and 8-15, 4 bits each
  F error;       // exact sum of squares
};

template <int kChannels>
HWY_INLINE void keep_better(SubsetCode<kChannels>& best, const SubsetCode<kChannels>& other) {
  const FloatMask better = hn::Lt(other.error, best.error);
  best.end0 = select(better, other.end0, best.end0);
  best.end1 = select(better, other.end1, best.end1);
  best.lowest = select(better, other.lowest, best.lowest);
  for (int half = 0; half < 2; ++half) best.indices[half] = select(better, other.indices[half], best.indices[half]);
  best.error = hn::Min(best.error, other.error);
}

// Codes for the two ends of a solution. The lowest bits are those that cost least; all 1 where `ones` is set.
template <class Format, int kChannels>
HWY_INLINE void quantize(const Solution<kChannels>& solution, FloatMask ones, SubsetCode<kChannels>& subset) {
  const Line<kChannels>& line = solution.line;
  if constexpr (Format::kSharedBits == 0) {
    subset.end0 = Format::nearest(line.end0, bits(0));
    subset.end1 = Format::nearest(line.end1, bits(0));
    subset.lowest = bits(0);
  } else {
    const Codes<kChannels> codes0[2] = {Format::nearest(line.end0, bits(0)), Format::nearest(line.end0, bits(1))};
    const Codes<kChannels> codes1[2] = {Format::nearest(line.end1, bits(0)), Format::nearest(line.end1, bits(1))};
    Color<kChannels> d0[2], d1[2];
    for (int bit = 0; bit < 2; ++bit) {
      d0[bit] = codes0[bit].value - line.end0;
      d1[bit] = codes1[bit].value - line.end1;
    }
    const F twice_b = hn::Add(solution.b, solution.b);
    const auto cost = [&](int bit0, int bit1) {
      return hn::Add(hn::Add(hn::Mul(solution.a, dot(d0[bit0], d0[bit0])), hn::Mul(solution.c, dot(d1[bit1], d1[bit1]))),
                     hn::Mul(twice_b, dot(d0[bit0], d1[bit1])));
    };
    F least = cost(1, 1);
    subset.end0 = codes0[1];
    subset.end1 = codes1[1];
    subset.lowest = bits(3);
    for (int pair = Format::kSharedBits == 1 ? 0 : 2; pair >= 0; --pair) {
      const F other = cost(pair & 1, pair >> 1);
      const FloatMask better = hn::AndNot(ones, hn::Lt(other, least));
      least = hn::IfThenElse(better, other, least);
      subset.end0 = select(better, codes0[pair & 1], subset.end0);
      subset.end1 = select(better, codes1[pair >> 1], subset.end1);
      subset.lowest = select(better, bits(static_cast<std::uint32_t>(pair)), subset.lowest);
    }
  }
}

// Indices for the codes, and the exact error of what the decoder makes of them.
template <int kIndexBits, int kChannels, class Part>
HWY_INLINE void evaluate(const Texels<kChannels>& texels, const Part& part, SubsetCode<kChannels>& subset) {
  const Projection<kChannels> projection({subset.end0.value, subset.end1.value}, kIndexBits);
  Color<kChannels> base, along;
  for (int c = 0; c < kChannels; ++c) {
    // The decoder rounds halves up; results are multiples of 1/64, so a 256th keeps them off the ties.
    base.c[c] = hn::Add(subset.end0.value.c[c], constant(1.0F / 256.0F));
    along.c[c] = hn::Mul(hn::Sub(subset.end1.value.c[c], subset.end0.value.c[c]), constant(1.0F / 64.0F));
  }
  subset.error = zero();
  for (std::size_t half = 0; half < 2; ++half) {
    U packed = bits(0);
    for (std::size_t i = half * 8 + 8; i-- > half * 8;) {
      const Color<kChannels> texel = texels.get(i);
      const F index = projection.index(texel);
      const F weight = projection.weight(index);
      Color<kChannels> decoded;
      for (int c = 0; c < kChannels; ++c) decoded.c[c] = rounded(hn::Add(base.c[c], hn::Mul(along.c[c], weight)));
      const Color<kChannels> d = decoded - texel;
      subset.error = hn::Add(subset.error, part.only(i, dot(d, d)));
      packed = hn::Or(hn::ShiftLeft<4>(packed), integer_bits(part.only(i, index)));
    }
    subset.indices[half] = packed;
  }
}

// `passes` rounds of least squares and rounding to codes, each from the codes of the one before; the best
// round counts. `ones` as above.
template <class Format, int kIndexBits, int kChannels, class Part>
HWY_INLINE SubsetCode<kChannels> fitted(const Texels<kChannels>& texels, const Part& part, FloatMask ones, int passes) {
  const Moments<kChannels> m = moments_of(texels, part);
  Line<kChannels> line = extremes(texels, part, m);
  SubsetCode<kChannels> best;
  for (int pass = 0; pass < passes; ++pass) {
    SubsetCode<kChannels> candidate;
    quantize<Format>(refined(line, kIndexBits, texels, part, m), ones, candidate);
    evaluate<kIndexBits>(texels, part, candidate);
    line = {candidate.end0.value, candidate.end1.value};
    if (pass == 0) {
      best = candidate;
    } else {
      keep_better(best, candidate);
    }
  }
  return best;
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
