// End points of BC6H: lines through half codes, moved to keep the sum of light, their codes in a mode, and
// what these cost. One block per SIMD lane. Included once per CPU target.
#if defined(VT_BUILDER_ENCODE_BC6H_FIT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC6H_FIT_INL_H
#undef VT_BUILDER_ENCODE_BC6H_FIT_INL_H
#else
#define VT_BUILDER_ENCODE_BC6H_FIT_INL_H
#endif

#include "builder/encode/bptc/bptc_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

constexpr float kLargestHalfCode = 31743.0F;  // 65504

// The light that a half code stands for: its exponent and mantissa are those of a float 112 octaves down.
HWY_INLINE F light(U code) { return hn::Mul(hn::BitCast(FloatTag(), hn::ShiftLeft<13>(code)), constant(0x1p112F)); }
// Light from one half code to the next: the value of the octave's first code / 1024; one step for zero and
// subnormals.
HWY_INLINE F light_step(U code) {
  const U octave = hn::Max(hn::And(code, bits(0x7C00)), bits(0x0400));
  return hn::Mul(light(octave), constant(1.0F / 1024.0F));
}

// One Newton step of the constraint "sum of light as in the source" for each channel, the texels keeping
// their positions, along the least squares' own quadratic form: with M its matrix (a b; b c) / 64^2 and g the
// derivative of the sum by the two ends, the cheapest change is M^-1 g (missing / g^T M^-1 g), and costs
// missing^2 / g^T M^-1 g of squared error. It is shortened where that is more than the line's own error (and
// one code a texel).
template <class Part>
HWY_INLINE Line<3> nearer_in_light(const Line<3>& line, const Projection<3>& projection, const Texels<3>& texels, const Part& part) {
  F a = zero(), b = zero(), c = zero();
  Color<3> missing, slope0, slope1, error;
  for (int k = 0; k < 3; ++k) missing.c[k] = slope0.c[k] = slope1.c[k] = error.c[k] = zero();
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<3> texel = texels.get(i);
    const F t = hn::Mul(projection.weight(projection.index(texel)), constant(1.0F / 64.0F));
    const F s = hn::Sub(constant(1.0F), t);
    a = hn::Add(a, part.only(i, hn::Mul(s, s)));
    b = hn::Add(b, part.only(i, hn::Mul(s, t)));
    c = hn::Add(c, part.only(i, hn::Mul(t, t)));
    for (int k = 0; k < 3; ++k) {
      const F fitted = rounded(clamped(hn::Add(hn::Mul(line.end0.c[k], s), hn::Mul(line.end1.c[k], t)), 0.0F, kLargestHalfCode));
      const U code = integer_bits(fitted);
      const F step = part.only(i, light_step(code));
      missing.c[k] = hn::Add(missing.c[k], part.only(i, hn::Sub(light(integer_bits(texel.c[k])), light(code))));
      slope0.c[k] = hn::Add(slope0.c[k], hn::Mul(step, s));
      slope1.c[k] = hn::Add(slope1.c[k], hn::Mul(step, t));
      const F d = part.only(i, hn::Sub(fitted, texel.c[k]));
      error.c[k] = hn::Add(error.c[k], hn::Mul(d, d));
    }
  }
  // Where all texels share one position both ends move alike: the inverse is then 1 / count for their sum.
  const F determinant = hn::Sub(hn::Mul(a, c), hn::Mul(b, b));
  const F count = part.count();
  const FloatMask solvable = hn::Gt(determinant, constant(1e-3F));
  const F scale = hn::Div(constant(1.0F), hn::IfThenElse(solvable, determinant, constant(1.0F)));
  Line<3> moved;
  for (int k = 0; k < 3; ++k) {
    const F both = hn::Div(hn::Add(slope0.c[k], slope1.c[k]), count);
    const F along0 = hn::IfThenElse(solvable, hn::Mul(hn::Sub(hn::Mul(c, slope0.c[k]), hn::Mul(b, slope1.c[k])), scale), both);
    const F along1 = hn::IfThenElse(solvable, hn::Mul(hn::Sub(hn::Mul(a, slope1.c[k]), hn::Mul(b, slope0.c[k])), scale), both);
    const F gain = hn::Add(hn::Mul(slope0.c[k], along0), hn::Mul(slope1.c[k], along1));
    const F factor = hn::IfThenElseZero(hn::Gt(gain, zero()), hn::Div(missing.c[k], hn::Max(gain, constant(1e-30F))));
    const F cost = hn::Mul(missing.c[k], factor);
    const F allowed = hn::Add(error.c[k], count);
    const F shortened =
        hn::IfThenElse(hn::Gt(cost, allowed), hn::Mul(factor, hn::Sqrt(hn::Div(allowed, hn::Max(cost, constant(1e-30F))))), factor);
    moved.end0.c[k] = clamped(hn::Add(line.end0.c[k], hn::Mul(along0, shortened)), 0.0F, kLargestHalfCode);
    moved.end1.c[k] = clamped(hn::Add(line.end1.c[k], hn::Mul(along1, shortened)), 0.0F, kLargestHalfCode);
  }
  return moved;
}

// Light grows faster than its slope, so the first step goes too far and the second comes back.
template <class Part>
HWY_INLINE Line<3> with_light_kept(const Line<3>& line, unsigned index_bits, const Texels<3>& texels, const Part& part) {
  const Projection<3> projection(line, index_bits);
  return nearer_in_light(nearer_in_light(line, projection, texels, part), projection, texels, part);
}

// End points as a mode stores them: code, and the decoder's 16-bit number for it.
struct HalfEnd {
  Color<3> code;
  Color<3> value;
};

// For `base_bits` below 16 a code stands for the middle of its interval, but the first and the last are 0 and
// 65535. In 16 bits it is itself.
HWY_INLINE HalfEnd half_end(const Color<3>& end, int base_bits) {
  const float codes = static_cast<float>(1U << base_bits);
  const float step = 65536.0F / codes;
  HalfEnd result;
  for (int k = 0; k < 3; ++k) {
    // The decoder takes 31/64 of the number and drops the fraction: aim at the middle of the numbers that
    // become this half.
    const F number = hn::Add(hn::Mul(end.c[k], constant(64.0F / 31.0F)), constant(32.0F / 31.0F));
    const F position = base_bits == 16 ? number : hn::Sub(hn::Mul(number, constant(1.0F / step)), constant(0.5F));
    const F code = rounded(clamped(position, 0.0F, codes - 1.0F));
    result.code.c[k] = code;
    if (base_bits == 16) {
      result.value.c[k] = code;
      continue;
    }
    F value = hn::Mul(hn::Add(code, constant(0.5F)), constant(step));
    value = hn::IfThenElse(hn::Eq(code, zero()), zero(), value);
    result.value.c[k] = hn::IfThenElse(hn::Eq(code, constant(codes - 1.0F)), constant(65535.0F), value);
  }
  return result;
}

HWY_INLINE HalfEnd select(FloatMask mask, const HalfEnd& yes, const HalfEnd& no) {
  return {select(mask, yes.code, no.code), select(mask, yes.value, no.value)};
}

// Indices for the ends, and the weights of end 1 that they stand for, of 64. The ends are near `kept`, which
// was moved away from `fitted` for the sake of light: each texel is taken to have moved with the line, or it
// would find an index that undoes it.
template <class Part>
HWY_INLINE void pick_indices(const HalfEnd& end0, const HalfEnd& end1, const Line<3>& fitted, const Line<3>& kept, unsigned index_bits,
                             const Texels<3>& texels, const Part& part, U (&indices)[2], F (&weights)[16]) {
  Line<3> line;
  Color<3> shift0, shift_along;
  for (int k = 0; k < 3; ++k) {
    // Where the decoded half of a 16-bit number lies on average, half codes being 64/31 numbers.
    line.end0.c[k] = hn::Sub(hn::Mul(end0.value.c[k], constant(31.0F / 64.0F)), constant(0.5F));
    line.end1.c[k] = hn::Sub(hn::Mul(end1.value.c[k], constant(31.0F / 64.0F)), constant(0.5F));
    shift0.c[k] = hn::Sub(kept.end0.c[k], fitted.end0.c[k]);
    shift_along.c[k] = hn::Mul(hn::Sub(hn::Sub(kept.end1.c[k], fitted.end1.c[k]), shift0.c[k]), constant(1.0F / 64.0F));
  }
  const Projection<3> on_fitted(fitted, index_bits);
  const Projection<3> projection(line, index_bits);
  for (std::size_t half = 0; half < 2; ++half) {
    U packed = bits(0);
    for (std::size_t i = half * 8 + 8; i-- > half * 8;) {
      const Color<3> texel = texels.get(i);
      const F fitted_weight = on_fitted.weight(on_fitted.index(texel));
      Color<3> moved;
      for (int k = 0; k < 3; ++k) moved.c[k] = hn::Add(texel.c[k], hn::Add(shift0.c[k], hn::Mul(shift_along.c[k], fitted_weight)));
      const F index = projection.index(moved);
      weights[i] = projection.weight(index);
      packed = hn::Or(hn::ShiftLeft<4>(packed), integer_bits(part.only(i, index)));
    }
    indices[half] = packed;
  }
}

// A candidate costs, for each channel of each subset, the squared error of what the decoder makes of it, in
// half codes, and so many times the least such error that would bring the sum of light back, but for a share
// that is free: small errors have no preferred direction and go away over many blocks. Tuned on the lights of
// a city by night, where one end of a block is dark and the other a lamp: so every level of 64 blocks and
// more keeps its light to 0.1 %. With a weight of 16 levels are off by 0.4 %; with none of the light free,
// blocks of two subsets are hardly taken and codes of a picture by day are worse by half.
constexpr float kLightWeight = 128.0F;
constexpr float kFreeLight = 0.02F;

// For each channel of a subset: its light, and kLightWeight over the square of the light that a unit of
// squared error buys at the texels' positions, see nearer_in_light().
struct SubsetLight {
  Color<3> total;
  Color<3> cost;
};
template <class Part>
HWY_INLINE SubsetLight light_of_subset(const F (&weights)[16], const Texels<3>& texels, const Part& part) {
  F a = zero(), b = zero(), c = zero();
  Color<3> slope0, slope1;
  SubsetLight result;
  for (int k = 0; k < 3; ++k) slope0.c[k] = slope1.c[k] = result.total.c[k] = zero();
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<3> texel = texels.get(i);
    const F t = hn::Mul(weights[i], constant(1.0F / 64.0F));
    const F s = hn::Sub(constant(1.0F), t);
    a = hn::Add(a, part.only(i, hn::Mul(s, s)));
    b = hn::Add(b, part.only(i, hn::Mul(s, t)));
    c = hn::Add(c, part.only(i, hn::Mul(t, t)));
    for (int k = 0; k < 3; ++k) {
      const U code = integer_bits(texel.c[k]);
      const F step = part.only(i, light_step(code));
      slope0.c[k] = hn::Add(slope0.c[k], hn::Mul(step, s));
      slope1.c[k] = hn::Add(slope1.c[k], hn::Mul(step, t));
      result.total.c[k] = hn::Add(result.total.c[k], part.only(i, light(code)));
    }
  }
  const F determinant = hn::Sub(hn::Mul(a, c), hn::Mul(b, b));
  const FloatMask solvable = hn::Gt(determinant, constant(1e-3F));
  const F divisor = hn::IfThenElse(solvable, determinant, hn::Max(part.count(), constant(1.0F)));
  for (int k = 0; k < 3; ++k) {
    const F both = hn::Add(slope0.c[k], slope1.c[k]);
    const F along0 = hn::Sub(hn::Mul(c, slope0.c[k]), hn::Mul(b, slope1.c[k]));
    const F along1 = hn::Sub(hn::Mul(a, slope1.c[k]), hn::Mul(b, slope0.c[k]));
    const F numerator = hn::IfThenElse(solvable, hn::Add(hn::Mul(slope0.c[k], along0), hn::Mul(slope1.c[k], along1)), hn::Mul(both, both));
    result.cost.c[k] = hn::Div(constant(kLightWeight), hn::Max(hn::Div(numerator, divisor), constant(1e-30F)));
  }
  return result;
}

// For each channel of a subset with the ends that decode to these numbers, a share `free_light` of the light
// being free.
template <class Part>
HWY_INLINE Color<3> channel_costs(const Color<3>& value0, const Color<3>& value1, const F (&weights)[16], const SubsetLight& wanted,
                                  float free_light, const Texels<3>& texels, const Part& part) {
  Color<3> base, along, squares, total, costs;
  for (int k = 0; k < 3; ++k) {
    // The decoder rounds halves up; results are multiples of 1/64, so a 256th keeps them off the ties.
    base.c[k] = hn::Add(value0.c[k], constant(1.0F / 256.0F));
    along.c[k] = hn::Mul(hn::Sub(value1.c[k], value0.c[k]), constant(1.0F / 64.0F));
    squares.c[k] = total.c[k] = zero();
  }
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<3> texel = texels.get(i);
    for (int k = 0; k < 3; ++k) {
      const F number = rounded(hn::Add(base.c[k], hn::Mul(along.c[k], weights[i])));
      // 31/64, the fraction dropped; again a 256th off the ties.
      const F decoded = rounded(hn::Sub(hn::Mul(number, constant(31.0F / 64.0F)), constant(127.0F / 256.0F)));
      const F d = hn::Sub(decoded, texel.c[k]);
      squares.c[k] = hn::Add(squares.c[k], part.only(i, hn::Mul(d, d)));
      total.c[k] = hn::Add(total.c[k], part.only(i, light(integer_bits(decoded))));
    }
  }
  for (int k = 0; k < 3; ++k) {
    const F missing = hn::Abs(hn::Sub(wanted.total.c[k], total.c[k]));
    const F excess = hn::Max(hn::Sub(missing, hn::Mul(constant(free_light), wanted.total.c[k])), zero());
    costs.c[k] = hn::Add(squares.c[k], hn::Mul(hn::Mul(excess, excess), wanted.cost.c[k]));
  }
  return costs;
}

// The sum over the channels, added to what is there.
HWY_INLINE F added(F sum, const Color<3>& costs) { return hn::Add(hn::Add(hn::Add(sum, costs.c[0]), costs.c[1]), costs.c[2]); }

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
