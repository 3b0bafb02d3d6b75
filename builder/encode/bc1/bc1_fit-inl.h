// The fits of a batch of BC1 blocks by least squares along the principal axis, and the table for one colour.
// Included once per SIMD target by bc1_encoder.cpp.
#if defined(VT_BUILDER_ENCODE_BC1_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC1_FIT_INL_H_
#undef VT_BUILDER_ENCODE_BC1_FIT_INL_H_
#else
#define VT_BUILDER_ENCODE_BC1_FIT_INL_H_
#endif

#include <array>

#include "builder/encode/bc1/bc1_kernel-inl.h"
#include "builder/encode/bc1/single_color_table.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {
// Direction of greatest variance, of no particular length; zero for a flat block.
HWY_INLINE Rgb principal_axis(const Moments& m) {
  const F n = m.count;
  const F rr = hn::Sub(hn::Mul(m.squares.r, n), hn::Mul(m.sum.r, m.sum.r));
  const F gg = hn::Sub(hn::Mul(m.squares.g, n), hn::Mul(m.sum.g, m.sum.g));
  const F bb = hn::Sub(hn::Mul(m.squares.b, n), hn::Mul(m.sum.b, m.sum.b));
  const F rg = hn::Sub(hn::Mul(m.rg, n), hn::Mul(m.sum.r, m.sum.g));
  const F rb = hn::Sub(hn::Mul(m.rb, n), hn::Mul(m.sum.r, m.sum.b));
  const F gb = hn::Sub(hn::Mul(m.gb, n), hn::Mul(m.sum.g, m.sum.b));

  // Divided by the trace, no product of the iteration overflows or vanishes: the largest eigenvalue is
  // between 1/3 and 1.
  const F trace = hn::Add(hn::Add(rr, gg), bb);
  const F scale = hn::Div(constant(1.0F), hn::Max(trace, constant(1.0F)));
  const Rgb row_r = Rgb{rr, rg, rb} * scale;
  const Rgb row_g = Rgb{rg, gg, gb} * scale;
  const Rgb row_b = Rgb{rb, gb, bb} * scale;

  // The row of the channel that varies most cannot be orthogonal to the axis.
  const auto g_first = hn::Gt(gg, rr);
  Rgb axis{hn::IfThenElse(g_first, row_g.r, row_r.r), hn::IfThenElse(g_first, row_g.g, row_r.g), hn::IfThenElse(g_first, row_g.b, row_r.b)};
  const auto b_first = hn::Gt(bb, hn::Max(rr, gg));
  axis = {hn::IfThenElse(b_first, row_b.r, axis.r), hn::IfThenElse(b_first, row_b.g, axis.g), hn::IfThenElse(b_first, row_b.b, axis.b)};
  for (int iteration = 0; iteration < 4; ++iteration) axis = {dot(row_r, axis), dot(row_g, axis), dot(row_b, axis)};
  return axis;
}

// End points, centred like the texels. Position 0 of the line is `end0`, position 3 is `end1`.
struct Line {
  Rgb end0;
  Rgb end1;
};

// Position (0..3, before truncation) of a texel = dot(texel, direction) + offset, clamped.
struct Projection {
  Rgb direction;
  F offset;

  HWY_INLINE explicit Projection(const Line& line) {
    const Rgb along = line.end1 - line.end0;
    const F length2 = dot(along, along);
    const F scale = hn::IfThenElseZero(hn::Gt(length2, hn::Zero(FloatTag())), hn::Div(constant(3.0F), length2));
    direction = along * scale;
    offset = hn::Sub(constant(0.5F), dot(line.end0, direction));
  }
  HWY_INLINE I position(const Rgb& texel) const { return truncated(clamped(hn::Add(dot(texel, direction), offset), 0.0F, 3.0F)); }
};

HWY_INLINE Line extremes_along(const Rgb& axis, const Moments& moments, const Texels& texels) {
  F low = constant(1e30F);
  F high = constant(-1e30F);
  for (std::size_t i = 0; i < 16; ++i) {
    const F t = dot(texels.get(i), axis);
    low = hn::Min(low, t);
    high = hn::Max(high, t);
  }
  const Rgb centre = moments.sum * hn::Div(constant(1.0F), moments.count);
  const F middle = dot(centre, axis);
  const F length2 = dot(axis, axis);
  const F scale = hn::IfThenElseZero(hn::Gt(length2, hn::Zero(FloatTag())), hn::Div(constant(1.0F), length2));
  return {centre + axis * hn::Mul(hn::Sub(low, middle), scale), centre + axis * hn::Mul(hn::Sub(high, middle), scale)};
}

// Codes and the values they decode to, of both end points of one channel.
struct ChannelEnds {
  I code0, code1;
  F value0, value1;  // centred
  F error;           // nine times the squared error of this channel, less a constant
};

// Least squares for one channel: minimise sum of (3 x - (3 - w) e0 - w e1)^2, with a = sum (3-w)^2, b = sum
// (3-w) w, c = sum w^2, x0 = sum (3-w) x, x1 = sum w x. Formulas: the normal equations.
struct Weights {
  F a, b, c;
  F three_over_determinant;
};

template <int bits>
HWY_INLINE F decoded(I code) {
  return float_from(hn::Or(hn::ShiftLeft<8 - bits>(code), hn::ShiftRight<2 * bits - 8>(code)));
}

template <int bits>
HWY_INLINE ChannelEnds solve_channel(const Weights& w, F x0, F x1, F mean) {
  const F end0 = hn::Add(hn::Mul(hn::Sub(hn::Mul(w.c, x0), hn::Mul(w.b, x1)), w.three_over_determinant), mean);
  const F end1 = hn::Add(hn::Mul(hn::Sub(hn::Mul(w.a, x1), hn::Mul(w.b, x0)), w.three_over_determinant), mean);

  // The best pair of codes is nearly always one of the four around the solution; the quadratic form says
  // which.
  constexpr float kTop = (1 << bits) - 1;
  const F steps = constant(kTop / 255.0F);
  const I one = hn::Set(IntTag(), 1);
  const I low0 = truncated(clamped(hn::Mul(end0, steps), 0.0F, kTop - 1.0F));
  const I low1 = truncated(clamped(hn::Mul(end1, steps), 0.0F, kTop - 1.0F));
  const I high0 = hn::Add(low0, one);
  const I high1 = hn::Add(low1, one);
  const F six = constant(6.0F);
  const F linear0 = hn::Mul(x0, six);
  const F linear1 = hn::Mul(x1, six);
  const F twice_b = hn::Add(w.b, w.b);
  const F low0_value = hn::Sub(decoded<bits>(low0), mean);
  const F high0_value = hn::Sub(decoded<bits>(high0), mean);
  const F low1_value = hn::Sub(decoded<bits>(low1), mean);
  const F high1_value = hn::Sub(decoded<bits>(high1), mean);
  // a e0^2 - 6 x0 e0, c e1^2 - 6 x1 e1, and the mixed term.
  const F low0_error = hn::Mul(low0_value, hn::Sub(hn::Mul(w.a, low0_value), linear0));
  const F high0_error = hn::Mul(high0_value, hn::Sub(hn::Mul(w.a, high0_value), linear0));
  const F low1_error = hn::Mul(low1_value, hn::Sub(hn::Mul(w.c, low1_value), linear1));
  const F high1_error = hn::Mul(high1_value, hn::Sub(hn::Mul(w.c, high1_value), linear1));
  const F low0_mixed = hn::Mul(twice_b, low0_value);
  const F high0_mixed = hn::Mul(twice_b, high0_value);
  const F ll = hn::Add(low0_error, hn::Add(low1_error, hn::Mul(low0_mixed, low1_value)));
  const F lh = hn::Add(low0_error, hn::Add(high1_error, hn::Mul(low0_mixed, high1_value)));
  const F hl = hn::Add(high0_error, hn::Add(low1_error, hn::Mul(high0_mixed, low1_value)));
  const F hh = hn::Add(high0_error, hn::Add(high1_error, hn::Mul(high0_mixed, high1_value)));

  const auto low_prefers_high1 = hn::Lt(lh, ll);
  const auto high_prefers_high1 = hn::Lt(hh, hl);
  const F best_low = hn::Min(ll, lh);
  const F best_high = hn::Min(hl, hh);
  const auto use_high0 = hn::Lt(best_high, best_low);
  const F value1_low = hn::IfThenElse(low_prefers_high1, high1_value, low1_value);
  const F value1_high = hn::IfThenElse(high_prefers_high1, high1_value, low1_value);
  ChannelEnds ends;
  ends.value0 = hn::IfThenElse(use_high0, high0_value, low0_value);
  ends.value1 = hn::IfThenElse(use_high0, value1_high, value1_low);
  ends.code0 = hn::IfThenElse(hn::RebindMask(IntTag(), use_high0), high0, low0);
  ends.code1 = hn::IfThenElse(hn::RebindMask(IntTag(), hn::Eq(ends.value1, high1_value)), high1, low1);
  ends.error = hn::Min(best_low, best_high);
  return ends;
}

struct Candidate {
  Line line;
  I color0, color1;  // 5:6:5
  F error;           // nine times the squared error, less nine times the sum of squares
};

HWY_INLINE I packed_565(I r, I g, I b) { return hn::Or(hn::Or(hn::ShiftLeft<11>(r), hn::ShiftLeft<5>(g)), b); }

// The least squares solution where the positions of the texels that count have the sums `sum_w` = sum w,
// `sum_ww` = sum w^2 and `x1` = sum w x.
HWY_INLINE Candidate solved(F sum_w, F sum_ww, const Rgb& x1, const Moments& moments) {
  const F three = constant(3.0F);
  const Rgb x0 = moments.sum * three - x1;
  Weights w;
  w.a = hn::Add(hn::Sub(hn::Mul(moments.count, constant(9.0F)), hn::Mul(sum_w, constant(6.0F))), sum_ww);
  w.b = hn::Sub(hn::Mul(sum_w, three), sum_ww);
  w.c = sum_ww;
  // Zero when all texels share one position; the end points then fall back to the mean, and the single-colour
  // table wins.
  const F determinant = hn::Sub(hn::Mul(w.a, w.c), hn::Mul(w.b, w.b));
  w.three_over_determinant = hn::IfThenElseZero(hn::Gt(determinant, hn::Zero(FloatTag())), hn::Div(three, determinant));

  const ChannelEnds r = solve_channel<5>(w, x0.r, x1.r, moments.mean.r);
  const ChannelEnds g = solve_channel<6>(w, x0.g, x1.g, moments.mean.g);
  const ChannelEnds b = solve_channel<5>(w, x0.b, x1.b, moments.mean.b);
  return {.line = {{r.value0, g.value0, b.value0}, {r.value1, g.value1, b.value1}},
          .color0 = packed_565(r.code0, g.code0, b.code0),
          .color1 = packed_565(r.code1, g.code1, b.code1),
          .error = hn::Add(hn::Add(r.error, g.error), b.error)};
}

// One refinement: positions on `line`, least squares, joint rounding.
HWY_INLINE Candidate refined(const Line& line, const Moments& moments, const Texels& texels) {
  const Projection projection(line);
  F sum_w = hn::Zero(FloatTag());
  F sum_ww = sum_w;
  Rgb x1{sum_w, sum_w, sum_w};
  for (std::size_t i = 0; i < 16; ++i) {
    const Rgb texel = texels.get(i);
    const F w = float_from(projection.position(texel));
    sum_w = hn::Add(sum_w, w);
    sum_ww = hn::Add(sum_ww, hn::Mul(w, w));
    x1 = x1 + texel * w;
  }
  // Texels that do not count lie at 0, all in one position, and are only in these two sums.
  const F others = hn::Sub(constant(16.0F), moments.count);
  const F other_w = float_from(projection.position({hn::Zero(FloatTag()), hn::Zero(FloatTag()), hn::Zero(FloatTag())}));
  sum_w = hn::Sub(sum_w, hn::Mul(others, other_w));
  sum_ww = hn::Sub(sum_ww, hn::Mul(others, hn::Mul(other_w, other_w)));
  return solved(sum_w, sum_ww, x1, moments);
}

HWY_INLINE Candidate better(const Candidate& p, const Candidate& q) {
  const auto use_q = hn::Lt(q.error, p.error);
  const auto use_q_int = hn::RebindMask(IntTag(), use_q);
  return {.line = {{hn::IfThenElse(use_q, q.line.end0.r, p.line.end0.r), hn::IfThenElse(use_q, q.line.end0.g, p.line.end0.g),
                    hn::IfThenElse(use_q, q.line.end0.b, p.line.end0.b)},
                   {hn::IfThenElse(use_q, q.line.end1.r, p.line.end1.r), hn::IfThenElse(use_q, q.line.end1.g, p.line.end1.g),
                    hn::IfThenElse(use_q, q.line.end1.b, p.line.end1.b)}},
          .color0 = hn::IfThenElse(use_q_int, q.color0, p.color0),
          .color1 = hn::IfThenElse(use_q_int, q.color1, p.color1),
          .error = hn::Min(p.error, q.error)};
}

// Positions of all texels on the line, two bits each, texel 0 lowest.
HWY_INLINE U packed_positions(const Line& line, const Texels& texels) {
  const Projection projection(line);
  const UintTag u;
  U packed = hn::Zero(u);
  for (std::size_t i = 16; i-- > 0;) packed = hn::Or(hn::ShiftLeft<2>(packed), hn::BitCast(u, projection.position(texels.get(i))));
  return packed;
}

// Entries of the single-colour tables, one int each so that a gather fetches them.
struct SingleColorEntries {
  std::array<std::int32_t, 256> bits5;
  std::array<std::int32_t, 256> bits6;
};
constexpr SingleColorEntries kSingleColor = [] {
  SingleColorEntries entries{};
  const auto table5 = make_single_color_table<5>();
  const auto table6 = make_single_color_table<6>();
  for (std::size_t v = 0; v < 256; ++v) {
    entries.bits5[v] = table5[v].end0 | table5[v].end1 << 8 | table5[v].value << 16;
    entries.bits6[v] = table6[v].end0 | table6[v].end1 << 8 | table6[v].value << 16;
  }
  return entries;
}();

// The whole block in the best approximation of its mean colour.
struct SingleColorBlock {
  I color0, color1;
  F error;
};

HWY_INLINE F single_color_error(F value, F mean, F sum, F count) {
  const F d = hn::Sub(value, mean);
  return hn::Mul(hn::Sub(hn::Mul(d, count), hn::Add(sum, sum)), d);
}

HWY_INLINE SingleColorBlock single_color_block(const Moments& m) {
  const IntTag i32;
  const I r = hn::GatherIndex(i32, kSingleColor.bits5.data(), truncated(m.mean.r));
  const I g = hn::GatherIndex(i32, kSingleColor.bits6.data(), truncated(m.mean.g));
  const I b = hn::GatherIndex(i32, kSingleColor.bits5.data(), truncated(m.mean.b));
  const I code = hn::Set(i32, 0xFF);
  SingleColorBlock block;
  block.color0 = packed_565(hn::And(r, code), hn::And(g, code), hn::And(b, code));
  block.color1 = packed_565(hn::And(hn::ShiftRight<8>(r), code), hn::And(hn::ShiftRight<8>(g), code), hn::And(hn::ShiftRight<8>(b), code));
  block.error = hn::Mul(hn::Add(hn::Add(single_color_error(float_from(hn::ShiftRight<16>(r)), m.mean.r, m.sum.r, m.count),
                                        single_color_error(float_from(hn::ShiftRight<16>(g)), m.mean.g, m.sum.g, m.count)),
                                single_color_error(float_from(hn::ShiftRight<16>(b)), m.mean.b, m.sum.b, m.count)),
                        constant(9.0F));
  return block;
}

// End points and what texels use, in any order of the end points: positions are from color0 (0) to color1
// (3).
struct Choice {
  I color0, color1;  // 5:6:5
  U positions;       // two bits each, texel 0 lowest
};

// The better of the line and of one colour for all texels.
HWY_INLINE Choice line_or_single_color(const Candidate& line, const Moments& moments, const Texels& texels) {
  const UintTag u;
  const IntTag i32;
  // Index 2 is 2/3 color0 + 1/3 color1: a third of the way from position 0 to 3, so position 1.
  const SingleColorBlock single = single_color_block(moments);
  // In a flat block the table is always right; the least-squares error knows nothing of the decoder's
  // rounding of thirds.
  const F spread = hn::Add(hn::Add(moments.squares.r, moments.squares.g), moments.squares.b);
  const auto use_single = hn::RebindMask(i32, hn::Or(hn::Le(single.error, line.error), hn::Eq(spread, hn::Zero(FloatTag()))));
  return {
      .color0 = hn::IfThenElse(use_single, single.color0, line.color0),
      .color1 = hn::IfThenElse(use_single, single.color1, line.color1),
      .positions = hn::IfThenElse(hn::RebindMask(u, use_single), hn::Set(u, 0x55555555U), packed_positions(line.line, texels)),
  };
}

HWY_INLINE Candidate fit_once(const Moments& moments, const Texels& texels) {
  const Line whole = extremes_along(principal_axis(moments), moments, texels);
  const Rgb little = (whole.end1 - whole.end0) * constant(0.05F);
  return refined({whole.end0 + little, whole.end1 - little}, moments, texels);
}

// Different starts end in different local optima; all passes compete. The insets were tuned on six aerial
// images and 1/f noise: the two one-sided starts gain 0.1 dB, another pass for each of them 0.05 dB at three
// quarters of the speed.
HWY_NOINLINE Candidate fit_lines(const Moments& moments, const Texels& texels) {
  const Line whole = extremes_along(principal_axis(moments), moments, texels);
  const Rgb along = whole.end1 - whole.end0;
  const Rgb little = along * constant(0.05F);
  const Rgb much = along * constant(0.25F);
  Candidate best = refined({whole.end0 + little, whole.end1 - little}, moments, texels);
  best = better(best, refined(best.line, moments, texels));
  best = better(best, refined({whole.end0 + much, whole.end1}, moments, texels));
  best = better(best, refined({whole.end0, whole.end1 - much}, moments, texels));
  best = better(best, refined(best.line, moments, texels));
  return best;
}
// Puts color0 above color1 and stores every block, `block_bytes` apart.
template <std::size_t block_bytes>
HWY_INLINE void store_blocks(const Choice& choice, std::uint8_t* blocks) {
  const IntTag i32;
  const UintTag u;
  U positions = choice.positions;
  const I color0 = choice.color0;
  const I color1 = choice.color1;

  // Exchanging the end points mirrors the positions: w becomes 3 - w.
  const auto exchange = hn::Lt(color0, color1);
  const I higher = hn::Max(color0, color1);
  I lower = hn::Min(color0, color1);
  positions = hn::Xor(positions, hn::IfThenElseZero(hn::RebindMask(u, exchange), hn::Set(u, 0xFFFFFFFFU)));
  // Equal end points would select the three-colour mode: move the unused one. Black has nothing below, so
  // there the used one is the lower.
  const auto equal = hn::Eq(higher, lower);
  const auto black = hn::And(equal, hn::Eq(higher, hn::Zero(i32)));
  const I one = hn::Set(i32, 1);
  lower = hn::IfThenElse(hn::AndNot(black, equal), hn::Sub(higher, one), lower);
  const I upper = hn::IfThenElse(black, one, higher);
  positions = hn::IfThenElse(hn::RebindMask(u, equal), hn::IfThenElseZero(hn::RebindMask(u, black), hn::Set(u, 0xFFFFFFFFU)), positions);

  // Positions 0 1 2 3 along the line are indices 0 2 3 1: a Gray code with its two bits exchanged.
  const U low_bits = hn::Set(u, 0x55555555U);
  const U halved = hn::ShiftRight<1>(positions);
  const U indices = hn::Or(hn::And(halved, low_bits), hn::ShiftLeft<1>(hn::And(hn::Xor(positions, halved), low_bits)));
  const U colors = hn::BitCast(u, hn::Or(upper, hn::ShiftLeft<16>(lower)));

  HWY_ALIGN_MAX std::uint32_t block_colors[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t block_indices[kMaxLanes];
  hn::Store(colors, u, block_colors);
  hn::Store(indices, u, block_indices);
  for (std::size_t i = 0; i < hn::Lanes(u); ++i) {
    const std::uint64_t block = block_colors[i] | std::uint64_t{block_indices[i]} << 32U;
    for (std::size_t byte = 0; byte < 8; ++byte) blocks[i * block_bytes + byte] = static_cast<std::uint8_t>(block >> (8 * byte));
  }
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // per-target include guard
