// Lines through the texels of a block, one block per SIMD lane: what the encoders of BC7 and BC6H share.
// Principal axis, extremes along it, and least squares for the end points given each texel's position.
// Included once per CPU target; no fused multiply-add and no approximate reciprocal, so that all targets
// round alike.
#if defined(VT_BUILDER_ENCODE_BPTC_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BPTC_LANES_INL_H
#undef VT_BUILDER_ENCODE_BPTC_LANES_INL_H
#else
#define VT_BUILDER_ENCODE_BPTC_LANES_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include "builder/encode/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

constexpr float kNoError = 1e30F;  // larger than any sum of squares

HWY_INLINE U bits(std::uint32_t value) { return hn::Set(UintTag(), value); }
HWY_INLINE F zero() { return hn::Zero(FloatTag()); }
HWY_INLINE FloatMask nowhere() { return hn::Lt(zero(), zero()); }
HWY_INLINE U select(FloatMask mask, U yes, U no) { return hn::IfThenElse(hn::RebindMask(UintTag(), mask), yes, no); }

// Adding 1.5 * 2^23 leaves no bits for a fraction: to nearest, ties to even, for |value| < 2^22. The integer
// is then in the lowest bits.
constexpr float kRounder = 12582912.0F;
HWY_INLINE F rounded(F value) { return hn::Sub(hn::Add(value, constant(kRounder)), constant(kRounder)); }
HWY_INLINE U integer_bits(F integer) { return hn::Sub(hn::BitCast(UintTag(), hn::Add(integer, constant(kRounder))), bits(0x4B400000)); }

template <int kChannels>
struct Color {
  F c[kChannels];
};
template <int kChannels>
HWY_INLINE Color<kChannels> operator-(const Color<kChannels>& p, const Color<kChannels>& q) {
  Color<kChannels> difference;
  for (int c = 0; c < kChannels; ++c) difference.c[c] = hn::Sub(p.c[c], q.c[c]);
  return difference;
}
template <int kChannels>
HWY_INLINE F dot(const Color<kChannels>& p, const Color<kChannels>& q) {
  F sum = hn::Mul(p.c[0], q.c[0]);
  for (int c = 1; c < kChannels; ++c) sum = hn::Add(sum, hn::Mul(p.c[c], q.c[c]));
  return sum;
}
template <int kChannels>
HWY_INLINE Color<kChannels> select(FloatMask mask, const Color<kChannels>& yes, const Color<kChannels>& no) {
  Color<kChannels> chosen;
  for (int c = 0; c < kChannels; ++c) chosen.c[c] = hn::IfThenElse(mask, yes.c[c], no.c[c]);
  return chosen;
}

// The texels of one batch: each vector is one texel of every block.
template <int kChannels>
struct Texels {
  HWY_ALIGN_MAX float v[16][kChannels][kMaxLanes];

  HWY_INLINE Color<kChannels> get(std::size_t i) const {
    Color<kChannels> color;
    for (int c = 0; c < kChannels; ++c) color.c[c] = hn::Load(FloatTag(), v[i][c]);
    return color;
  }
  HWY_INLINE void set(std::size_t i, int channel, F value) { hn::Store(value, FloatTag(), v[i][channel]); }
};

// The texels of a block that share two end points: all of them, or those with their bit in `mask`. `only`
// makes the others 0.
struct WholeBlock {
  HWY_INLINE F only(std::size_t, F value) const { return value; }
  HWY_INLINE F count() const { return constant(16.0F); }
};
struct Subset {
  U mask;
  HWY_INLINE F only(std::size_t i, F value) const {
    return hn::IfThenElseZero(hn::RebindMask(FloatTag(), hn::TestBit(mask, bits(1U << i))), value);
  }
  HWY_INLINE F count() const {
    F sum = zero();
    for (std::size_t i = 0; i < 16; ++i) sum = hn::Add(sum, only(i, constant(1.0F)));
    return sum;
  }
};

template <int kChannels>
struct Line {
  Color<kChannels> end0, end1;
};

template <int kChannels>
struct Moments {
  F count;
  Color<kChannels> sum;
  Color<kChannels> mean;
  Color<kChannels> rows[kChannels];  // sums of products of what remains without the mean
};

template <int kChannels, class Part>
HWY_INLINE Moments<kChannels> moments_of(const Texels<kChannels>& texels, const Part& part) {
  Moments<kChannels> m;
  m.count = part.count();
  for (int c = 0; c < kChannels; ++c) {
    m.sum.c[c] = zero();
    for (int d = 0; d < kChannels; ++d) m.rows[c].c[d] = zero();
  }
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<kChannels> texel = texels.get(i);
    for (int c = 0; c < kChannels; ++c) m.sum.c[c] = hn::Add(m.sum.c[c], part.only(i, texel.c[c]));
  }
  for (int c = 0; c < kChannels; ++c) m.mean.c[c] = hn::Div(m.sum.c[c], m.count);
  for (std::size_t i = 0; i < 16; ++i) {
    Color<kChannels> texel = texels.get(i);
    for (int c = 0; c < kChannels; ++c) texel.c[c] = part.only(i, hn::Sub(texel.c[c], m.mean.c[c]));
    for (int c = 0; c < kChannels; ++c)
      for (int d = c; d < kChannels; ++d) m.rows[c].c[d] = hn::Add(m.rows[c].c[d], hn::Mul(texel.c[c], texel.c[d]));
  }
  for (int c = 0; c < kChannels; ++c)
    for (int d = 0; d < c; ++d) m.rows[c].c[d] = m.rows[d].c[c];
  return m;
}

// Direction of greatest variance, of no particular length, by power iteration; zero where all texels are
// alike.
template <int kChannels>
HWY_INLINE Color<kChannels> principal_axis(const Color<kChannels> (&rows)[kChannels], int iterations) {
  // Divided by the trace, no product overflows or vanishes: the largest eigenvalue is between 1 / kChannels
  // and 1.
  F trace = rows[0].c[0];
  for (int c = 1; c < kChannels; ++c) trace = hn::Add(trace, rows[c].c[c]);
  const F scale = hn::Div(constant(1.0F), hn::Max(trace, constant(1e-3F)));
  Color<kChannels> scaled[kChannels];
  for (int c = 0; c < kChannels; ++c)
    for (int d = 0; d < kChannels; ++d) scaled[c].c[d] = hn::Mul(rows[c].c[d], scale);

  // The row of the channel that varies most cannot be orthogonal to the axis.
  Color<kChannels> axis = scaled[0];
  F largest = rows[0].c[0];
  for (int c = 1; c < kChannels; ++c) {
    axis = select(hn::Gt(rows[c].c[c], largest), scaled[c], axis);
    largest = hn::Max(largest, rows[c].c[c]);
  }
  for (int i = 0; i < iterations; ++i) {
    Color<kChannels> next;
    for (int c = 0; c < kChannels; ++c) next.c[c] = dot(scaled[c], axis);
    axis = next;
  }
  return axis;
}

// The part of the axis through the mean that the texels' projections cover.
template <int kChannels, class Part>
HWY_INLINE Line<kChannels> extremes(const Texels<kChannels>& texels, const Part& part, const Moments<kChannels>& m) {
  const Color<kChannels> axis = principal_axis(m.rows, 4);
  F low = zero(), high = zero();
  for (std::size_t i = 0; i < 16; ++i) {
    Color<kChannels> texel = texels.get(i);
    for (int c = 0; c < kChannels; ++c) texel.c[c] = hn::Sub(texel.c[c], m.mean.c[c]);
    const F along = part.only(i, dot(texel, axis));
    low = hn::Min(low, along);
    high = hn::Max(high, along);
  }
  const F length2 = dot(axis, axis);
  const F scale = hn::IfThenElseZero(hn::Gt(length2, zero()), hn::Div(constant(1.0F), length2));
  low = hn::Mul(low, scale);
  high = hn::Mul(high, scale);
  Line<kChannels> line;
  for (int c = 0; c < kChannels; ++c) {
    line.end0.c[c] = hn::Add(m.mean.c[c], hn::Mul(axis.c[c], low));
    line.end1.c[c] = hn::Add(m.mean.c[c], hn::Mul(axis.c[c], high));
  }
  return line;
}

// Index of the position on a line nearest to a texel, as if the positions were equally spaced: BPTC's weights
// are within 1/128 of that.
template <int kChannels>
struct Projection {
  Color<kChannels> direction;
  F offset;
  float last;

  HWY_INLINE Projection(const Line<kChannels>& line, unsigned index_bits) : last(static_cast<float>((1U << index_bits) - 1U)) {
    for (int c = 0; c < kChannels; ++c) direction.c[c] = hn::Sub(line.end1.c[c], line.end0.c[c]);
    const F length2 = dot(direction, direction);
    const F scale = hn::IfThenElseZero(hn::Gt(length2, zero()), hn::Div(constant(last), length2));
    for (int c = 0; c < kChannels; ++c) direction.c[c] = hn::Mul(direction.c[c], scale);
    offset = hn::Sub(zero(), dot(line.end0, direction));
  }
  HWY_INLINE F index(const Color<kChannels>& texel) const { return rounded(clamped(hn::Add(dot(texel, direction), offset), 0.0F, last)); }
  // Weight of end 1 for that index, of 64: store/texel/bptc_table.h's tables are 64 index / last, rounded.
  HWY_INLINE F weight(F index) const { return rounded(hn::Mul(index, constant(64.0F / last))); }
};

// End points that minimise a squared error, and how it grows away from them: with d0, d1 the changes of the
// ends it is larger by (a d0^2 + 2 b d0 d1 + c d1^2) / 64^2, summed over the channels.
template <int kChannels>
struct Solution {
  Line<kChannels> line;
  F a, b, c;
};

// Least squares: the end points that fit the texels best at the positions they have on `line`. With w the
// weight of end 1 (of 64) and a = sum (64-w)^2, b = sum (64-w) w, c = sum w^2, the normal equations are
//   a e0 + b e1 = 64 sum (64-w) x
//   b e0 + c e1 = 64 sum w x
template <int kChannels, class Part>
HWY_INLINE Solution<kChannels> refined(const Line<kChannels>& line, unsigned index_bits, const Texels<kChannels>& texels, const Part& part,
                                       const Moments<kChannels>& m) {
  const Projection<kChannels> projection(line, index_bits);
  F sum_w = zero(), sum_ww = zero();
  Color<kChannels> x1;
  for (int c = 0; c < kChannels; ++c) x1.c[c] = zero();
  for (std::size_t i = 0; i < 16; ++i) {
    const Color<kChannels> texel = texels.get(i);
    const F w = part.only(i, projection.weight(projection.index(texel)));
    sum_w = hn::Add(sum_w, w);
    sum_ww = hn::Add(sum_ww, hn::Mul(w, w));
    for (int c = 0; c < kChannels; ++c) x1.c[c] = hn::Add(x1.c[c], hn::Mul(texel.c[c], w));
  }
  const F full = constant(64.0F);
  const F a = hn::Add(hn::Sub(hn::Mul(m.count, constant(4096.0F)), hn::Mul(sum_w, constant(128.0F))), sum_ww);
  const F b = hn::Sub(hn::Mul(sum_w, full), sum_ww);
  const F determinant = hn::Sub(hn::Mul(a, sum_ww), hn::Mul(b, b));
  // Zero where all texels share one position: both ends are then the mean.
  const FloatMask solvable = hn::Gt(determinant, zero());
  const F scale = hn::Div(full, hn::IfThenElse(solvable, determinant, constant(1.0F)));
  Solution<kChannels> solution;
  solution.a = a, solution.b = b, solution.c = sum_ww;
  for (int c = 0; c < kChannels; ++c) {
    const F x0 = hn::Sub(hn::Mul(m.sum.c[c], full), x1.c[c]);
    const F end0 = hn::Mul(hn::Sub(hn::Mul(sum_ww, x0), hn::Mul(b, x1.c[c])), scale);
    const F end1 = hn::Mul(hn::Sub(hn::Mul(a, x1.c[c]), hn::Mul(b, x0)), scale);
    solution.line.end0.c[c] = hn::IfThenElse(solvable, end0, m.mean.c[c]);
    solution.line.end1.c[c] = hn::IfThenElse(solvable, end1, m.mean.c[c]);
  }
  return solution;
}

// What is left of the variance without its greatest direction: the squared error of a line without
// quantisation.
template <int kChannels>
HWY_INLINE F off_axis(const Color<kChannels> (&rows)[kChannels]) {
  const Color<kChannels> axis = principal_axis(rows, 3);
  F trace = rows[0].c[0];
  for (int c = 1; c < kChannels; ++c) trace = hn::Add(trace, rows[c].c[c]);
  Color<kChannels> image;
  for (int c = 0; c < kChannels; ++c) image.c[c] = dot(rows[c], axis);
  // Rayleigh's quotient.
  const F length2 = dot(axis, axis);
  const F along = hn::Div(dot(image, axis), hn::Max(length2, constant(1e-20F)));
  return hn::Sub(trace, along);
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
