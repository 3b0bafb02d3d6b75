// The best fit of a batch of BC1 blocks. Included once per SIMD target by bc1_encoder.cpp.
//
// Cluster fit: in the order of the texels along a line, each of the 969 ways to cut them into four runs has
// its least squares solution, and only those whose error before rounding is below the best so far are rounded
// to codes. Then the line of the best gives a new order. At last single steps of single codes, judged by what
// the decoder makes of them.
#if defined(VT_BUILDER_ENCODE_BC1_CLUSTER_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC1_CLUSTER_FIT_INL_H_
#undef VT_BUILDER_ENCODE_BC1_CLUSTER_FIT_INL_H_
#else
#define VT_BUILDER_ENCODE_BC1_CLUSTER_FIT_INL_H_
#endif

#include "builder/encode/bc1/bc1_fit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// Texels in the order of their projections, as running sums: sum[k] and count[k] are over the first k of
// those that count.
struct Order {
  Rgb sum[17];
  F count[17];
};

struct KeyedTexel {
  F key;
  Rgb texel;
  F weight;
};

HWY_INLINE void sort_two(KeyedTexel& p, KeyedTexel& q) {
  const auto exchange = hn::Lt(q.key, p.key);
  const auto exchange_if = [&](F& x, F& y) {
    const F lower = hn::IfThenElse(exchange, y, x);
    y = hn::IfThenElse(exchange, x, y);
    x = lower;
  };
  exchange_if(p.key, q.key);
  exchange_if(p.texel.r, q.texel.r);
  exchange_if(p.texel.g, q.texel.g);
  exchange_if(p.texel.b, q.texel.b);
  exchange_if(p.weight, q.weight);
}

HWY_NOINLINE Order order_along(const Rgb& axis, const Texels& texels) {
  KeyedTexel keyed[16];
  for (std::size_t i = 0; i < 16; ++i) {
    const Rgb texel = texels.get(i);
    keyed[i] = {.key = dot(texel, axis), .texel = texel, .weight = hn::Load(FloatTag(), texels.weight[i])};
  }
  // Odd-even merge sort (Batcher).
  for (std::size_t p = 1; p < 16; p *= 2)
    for (std::size_t k = p; k >= 1; k /= 2)
      for (std::size_t j = k % p; j + k < 16; j += 2 * k)
        for (std::size_t i = 0; i < k && i + j + k < 16; ++i)
          if ((i + j) / (2 * p) == (i + j + k) / (2 * p)) sort_two(keyed[i + j], keyed[i + j + k]);

  const F zero = hn::Zero(FloatTag());
  Order order;
  order.sum[0] = {zero, zero, zero};
  order.count[0] = zero;
  for (std::size_t k = 0; k < 16; ++k) {
    order.sum[k + 1] = order.sum[k] + keyed[k].texel;
    order.count[k + 1] = hn::Add(order.count[k], keyed[k].weight);
  }
  return order;
}

// The best of `best` and of all partitions of one order. Positions 0 1 2 3 have the runs that end before i,
// j, k and 16.
HWY_NOINLINE Candidate best_partition(const Order& order, Candidate best, const Moments& moments) {
  const FloatTag f;
  const F three_count = hn::Mul(moments.count, constant(3.0F));
  const F nine_count = hn::Mul(moments.count, constant(9.0F));
  const Rgb three_sum = moments.sum * constant(3.0F);
  for (std::size_t k = 0; k <= 16; ++k) {
    for (std::size_t j = 0; j <= k; ++j) {
      const Rgb sum_jk = order.sum[j] + order.sum[k];
      const F count_jk = hn::Add(order.count[j], order.count[k]);
      const F square_jk = hn::Add(hn::Mul(order.count[j], constant(3.0F)), hn::Mul(order.count[k], constant(5.0F)));
      for (std::size_t i = 0; i <= j; ++i) {
        const Rgb x0 = sum_jk + order.sum[i];
        const Rgb x1 = three_sum - x0;
        const F sum_w = hn::Sub(three_count, hn::Add(count_jk, order.count[i]));
        const F sum_ww = hn::Sub(nine_count, hn::Add(square_jk, order.count[i]));
        const F a = hn::Add(hn::Sub(nine_count, hn::Mul(sum_w, constant(6.0F))), sum_ww);
        const F b = hn::Sub(hn::Mul(sum_w, constant(3.0F)), sum_ww);
        const F determinant = hn::Sub(hn::Mul(a, sum_ww), hn::Mul(b, b));
        // The error of the solution before rounding and clamping, on the scale of Candidate::error; compared
        // without a division.
        const F cross = hn::Mul(b, dot(x0, x1));
        const F explained = hn::Sub(hn::Add(hn::Mul(sum_ww, dot(x0, x0)), hn::Mul(a, dot(x1, x1))), hn::Add(cross, cross));
        const auto promising = hn::Lt(hn::Mul(explained, constant(-9.0F)), hn::Mul(best.error, determinant));
        const auto tried = hn::And(promising, hn::Gt(determinant, hn::Zero(f)));
        if (hn::AllFalse(f, tried)) continue;
        Candidate partition = solved(sum_w, sum_ww, x1, moments);
        // A lane that was not promising must not depend on its neighbours.
        partition.error = hn::IfThenElse(tried, partition.error, constant(1e30F));
        best = better(best, partition);
      }
    }
  }
  return best;
}

HWY_NOINLINE Candidate cluster_fit(const Candidate& known, const Moments& moments, const Texels& texels) {
  Candidate best = best_partition(order_along(principal_axis(moments), texels), known, moments);
  for (int round = 0; round < 2; ++round) best = best_partition(order_along(best.line.end1 - best.line.end0, texels), best, moments);
  return best;
}

// The four colours that a decoder makes of a pair, centred like the texels, in the order of positions.
struct Palette {
  Rgb colors[4];
};

template <int bits>
HWY_INLINE void decode_channel(I code0, I code1, F mean, F (&values)[4]) {
  const F end0 = decoded<bits>(code0);
  const F end1 = decoded<bits>(code1);
  // A little above a third: the product of a multiple of three does not fall below the whole number.
  const F third = constant(0.33333334F);
  const F one = constant(1.0F);
  const F near0 = float_from(truncated(hn::Mul(hn::Add(hn::Add(hn::Add(end0, end0), end1), one), third)));
  const F near1 = float_from(truncated(hn::Mul(hn::Add(hn::Add(hn::Add(end1, end1), end0), one), third)));
  values[0] = hn::Sub(end0, mean);
  values[1] = hn::Sub(near0, mean);
  values[2] = hn::Sub(near1, mean);
  values[3] = hn::Sub(end1, mean);
}

HWY_INLINE Palette palette_of(I color0, I color1, const Rgb& mean) {
  const I five = hn::Set(IntTag(), 31);
  const I six = hn::Set(IntTag(), 63);
  F r[4], g[4], b[4];
  decode_channel<5>(hn::And(hn::ShiftRight<11>(color0), five), hn::And(hn::ShiftRight<11>(color1), five), mean.r, r);
  decode_channel<6>(hn::And(hn::ShiftRight<5>(color0), six), hn::And(hn::ShiftRight<5>(color1), six), mean.g, g);
  decode_channel<5>(hn::And(color0, five), hn::And(color1, five), mean.b, b);
  Palette palette;
  for (std::size_t i = 0; i < 4; ++i) palette.colors[i] = {r[i], g[i], b[i]};
  return palette;
}

struct Scored {
  Choice choice;
  F error;  // squared, as decoded, over the texels that count: a whole number
};

// Each texel in its nearest position. Of equals the lowest.
HWY_NOINLINE Scored scored(I color0, I color1, const Moments& moments, const Texels& texels) {
  const FloatTag f;
  const UintTag u;
  const Palette palette = palette_of(color0, color1, moments.mean);
  Scored result{.choice = {.color0 = color0, .color1 = color1, .positions = hn::Zero(u)}, .error = hn::Zero(f)};
  for (std::size_t i = 16; i-- > 0;) {
    const Rgb texel = texels.get(i);
    const Rgb to_first = texel - palette.colors[0];
    F nearest = dot(to_first, to_first);
    U position = hn::Zero(u);
    for (std::uint32_t w = 1; w < 4; ++w) {
      const Rgb to = texel - palette.colors[w];
      const F distance = dot(to, to);
      position = hn::IfThenElse(hn::RebindMask(u, hn::Lt(distance, nearest)), hn::Set(u, w), position);
      nearest = hn::Min(nearest, distance);
    }
    result.error = hn::Add(result.error, hn::Mul(nearest, hn::Load(f, texels.weight[i])));
    result.choice.positions = hn::Or(hn::ShiftLeft<2>(result.choice.positions), position);
  }
  return result;
}

HWY_INLINE Scored better(const Scored& p, const Scored& q) {
  const auto use_q = hn::Lt(q.error, p.error);
  const auto use_q_int = hn::RebindMask(IntTag(), use_q);
  const auto use_q_uint = hn::RebindMask(UintTag(), use_q);
  return {.choice = {.color0 = hn::IfThenElse(use_q_int, q.choice.color0, p.choice.color0),
                     .color1 = hn::IfThenElse(use_q_int, q.choice.color1, p.choice.color1),
                     .positions = hn::IfThenElse(use_q_uint, q.choice.positions, p.choice.positions)},
          .error = hn::Min(p.error, q.error)};
}

// `color` with one channel moved by `step` (of its lowest bit, at `shift`), where it stays within its bits.
HWY_INLINE I moved(I color, int shift, int top, int step) {
  const IntTag i32;
  const I code = hn::And(hn::ShiftRightSame(color, shift), hn::Set(i32, top));
  const I wanted = hn::Min(hn::Max(hn::Add(code, hn::Set(i32, step)), hn::Zero(i32)), hn::Set(i32, top));
  return hn::Add(color, hn::ShiftLeftSame(hn::Sub(wanted, code), shift));
}

// The better of two fits, and of steps from there.
HWY_NOINLINE Choice best_of(const Choice& normal, const Candidate& cluster, const Moments& moments, const Texels& texels) {
  struct Channel {
    int shift, top;
  };
  constexpr Channel kChannels[] = {{11, 31}, {5, 63}, {0, 31}};
  Scored best = better(scored(normal.color0, normal.color1, moments, texels), scored(cluster.color0, cluster.color1, moments, texels));
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (const Channel& channel : kChannels) {
      for (const int step : {-1, 1}) {
        const I color0 = moved(best.choice.color0, channel.shift, channel.top, step);
        best = better(best, scored(color0, best.choice.color1, moments, texels));
        const I color1 = moved(best.choice.color1, channel.shift, channel.top, step);
        best = better(best, scored(best.choice.color0, color1, moments, texels));
      }
    }
  }
  return best.choice;
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // per-target include guard
