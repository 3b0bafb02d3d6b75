#include "builder/pyramid/reduce_rows.h"

#include <algorithm>

#include "builder/channels/codec/channel_codec.h"

// Highway compiles this file once for each CPU target and chooses at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/pyramid/reduce_rows.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vt::pyramid::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Sum over symmetric pairs; `load(t)` gives the vector under tap t. Add and Mul, never MulAdd: a fused one
// rounds once and exists on some CPUs only.
template <int kTaps, class D, class Load>
HWY_INLINE hn::Vec<D> weighted_pairs(D d, const HalvingKernel& kernel, const Load& load) {
  auto sum = hn::Mul(hn::Set(d, kernel.weight[0]), hn::Add(load(0), load(kTaps - 1)));
  for (int t = 1; t < kTaps / 2; ++t)
    sum = hn::Add(sum, hn::Mul(hn::Set(d, kernel.weight[static_cast<std::size_t>(t)]), hn::Add(load(t), load(kTaps - 1 - t))));
  return sum;
}

template <int kTaps>
void combine(const float* const* rows, const HalvingKernel& kernel, std::size_t count, float* out) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(weighted_pairs<kTaps>(d, kernel, [&](int t) { return hn::LoadU(d, rows[t] + i); }), d, out + i);
  const hn::CappedTag<float, 1> one;
  for (; i < count; ++i) hn::StoreU(weighted_pairs<kTaps>(one, kernel, [&](int t) { return hn::LoadU(one, rows[t] + i); }), one, out + i);
}

// Fine texel 2 i + o of a row is even[i + o / 2] or odd[i + (o - 1) / 2]; both can be read `margin` texels
// before and after the `count`.
struct SplitRow {
  const float* even;
  const float* odd;

  [[nodiscard]] const float* at_offset(int o) const { return (o & 1) != 0 ? odd + (o - 1) / 2 : even + o / 2; }  // exact: an even numerator
};

SplitRow split_row(const float* row, std::size_t margin, std::size_t count, float* scratch) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  const std::size_t pairs = count + 2 * margin;
  float* const even = scratch;
  float* const odd = scratch + pairs + 16;
  const float* const first = row - 2 * margin;
  std::size_t p = 0;
  for (; p + lanes <= pairs; p += lanes) {
    hn::Vec<decltype(d)> e;
    hn::Vec<decltype(d)> o;
    hn::LoadInterleaved2(d, first + 2 * p, e, o);
    hn::StoreU(e, d, even + p);
    hn::StoreU(o, d, odd + p);
  }
  for (; p < pairs; ++p) {
    even[p] = first[2 * p];
    odd[p] = first[2 * p + 1];
  }
  return {even + margin, odd + margin};
}

// De-interleaves first, so that every tap is a plain load.
template <int kTaps>
void halve(const float* row, const HalvingKernel& kernel, std::size_t count, float* scratch, float* out) {
  constexpr int kReach = kTaps / 2 - 1;
  const SplitRow split = split_row(row, (kReach + 1) / 2, count, scratch);
  const float* taps[kTaps];
  for (int t = 0; t < kTaps; ++t) taps[t] = split.at_offset(t - kReach);
  combine<kTaps>(taps, kernel, count, out);
}

// One vector of texels of which some are not all there.
template <int kTaps, class D>
HWY_INLINE void combine_partial_at(D d, const float* const* weights, std::span<const float* const* const> planes,
                                   const HalvingKernel& kernel, std::size_t i, float* const* out) {
  using V = hn::Vec<D>;
  constexpr int kFirst = kTaps / 2 - 1;
  constexpr int kSecond = kTaps / 2;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0F);
  V least = hn::LoadU(d, weights[0] + i);
  for (int t = 1; t < kTaps; ++t) least = hn::Min(least, hn::LoadU(d, weights[t] + i));
  const auto is_whole = hn::Eq(least, one);
  if (hn::AllTrue(d, is_whole)) return;

  const V first = hn::LoadU(d, weights[kFirst] + i);
  const V second = hn::LoadU(d, weights[kSecond] + i);
  V of_first = hn::Set(d, 0.5F);
  V of_second = of_first;
  HWY_ALIGN float factors[kTaps * hn::MaxLanes(d)];
  const auto factor = [&](int t) { return factors + static_cast<std::size_t>(t) * hn::MaxLanes(d); };
  const auto share = [&](V part, V whole) HWY_ATTR { return hn::IfThenElseZero(hn::Gt(whole, zero), hn::Div(part, whole)); };
  for (int t = 0; t < kTaps; ++t) {
    if (t == kFirst || t == kSecond) continue;
    const bool is_odd = ((t - kFirst) & 1) != 0;
    const V here = hn::LoadU(d, weights[t] + i);
    const V partner = is_odd ? first : second;
    const V both = hn::Min(here, partner);
    const V weight = hn::Set(d, kernel.weight[static_cast<std::size_t>(t)]);
    hn::Store(hn::Mul(weight, share(both, here)), d, factor(t));
    const V given = hn::Mul(weight, share(both, partner));
    if (is_odd)
      of_first = hn::Sub(of_first, given);
    else
      of_second = hn::Sub(of_second, given);
  }
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const float* const* const rows = planes[p];
    V sum = hn::Add(hn::Mul(of_first, hn::LoadU(d, rows[kFirst] + i)), hn::Mul(of_second, hn::LoadU(d, rows[kSecond] + i)));
    for (int t = 0; t < kTaps; ++t)
      if (t != kFirst && t != kSecond) sum = hn::Add(sum, hn::Mul(hn::Load(d, factor(t)), hn::LoadU(d, rows[t] + i)));
    hn::StoreU(hn::IfThenElse(is_whole, hn::LoadU(d, out[p] + i), sum), d, out[p] + i);
  }
}

template <int kTaps>
void combine_partial(const float* const* weights, std::span<const float* const* const> planes, const HalvingKernel& kernel,
                     std::size_t count, float* const* out) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) combine_partial_at<kTaps>(d, weights, planes, kernel, i, out);
  const hn::CappedTag<float, 1> one;
  for (; i < count; ++i) combine_partial_at<kTaps>(one, weights, planes, kernel, i, out);
}

template <int kTaps>
void halve_partial(const float* weights, std::span<const float* const> planes, const HalvingKernel& kernel, std::size_t count,
                   float* scratch, float* const* out) {
  constexpr int kReach = kTaps / 2 - 1;
  constexpr std::size_t kMargin = (kReach + 1) / 2;
  // Most rows are whole but for a few texels at an end.
  const auto is_one = [](float weight) { return weight == 1.0F; };
  const float* const begin = weights - kReach;
  const float* const end = weights + 2 * count + kReach;
  const std::ptrdiff_t west = std::find_if_not(begin, end, is_one) - weights;
  if (weights + west == end) return;
  std::ptrdiff_t east = end - weights;
  while (is_one(weights[east - 1])) --east;
  // Texel x is under the taps of the coarse texels from (x - reach - 1) / 2 to (x + reach) / 2.
  const auto first = static_cast<std::size_t>(std::max<std::ptrdiff_t>((west - kReach) / 2, 0));
  const std::size_t last = std::min(static_cast<std::size_t>((east - 1 + kReach) / 2) + 1, count);
  const std::size_t part = last - first;

  const std::size_t step = halve_scratch_floats(part);
  const float* taps[channels::kMaxPlanes + 1][kTaps];
  const float* const* rows[channels::kMaxPlanes];
  float* results[channels::kMaxPlanes];
  const auto split_taps = [&](const float* row, std::size_t at) {
    const SplitRow split = split_row(row + 2 * first, kMargin, part, scratch + at * step);
    for (int t = 0; t < kTaps; ++t) taps[at][t] = split.at_offset(t - kReach);
  };
  for (std::size_t p = 0; p < planes.size(); ++p) {
    split_taps(planes[p], p);
    rows[p] = taps[p];
    results[p] = out[p] + first;
  }
  split_taps(weights, planes.size());
  combine_partial<kTaps>(taps[planes.size()], std::span(rows, planes.size()), kernel, part, results);
}

// out[i] = combine(upper[2 i], upper[2 i + 1], lower[2 i], lower[2 i + 1]).
template <class Combine>
HWY_INLINE void combine_four(const float* upper, const float* lower, std::size_t count, float* out, const Combine& combine) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    V upper_even;
    V upper_odd;
    V lower_even;
    V lower_odd;
    hn::LoadInterleaved2(d, upper + 2 * i, upper_even, upper_odd);
    hn::LoadInterleaved2(d, lower + 2 * i, lower_even, lower_odd);
    hn::StoreU(combine(d, upper_even, upper_odd, lower_even, lower_odd), d, out + i);
  }
  const hn::CappedTag<float, 1> one;
  for (; i < count; ++i) {
    const auto at = [&](const float* row, std::size_t x) { return hn::LoadU(one, row + x); };
    hn::StoreU(combine(one, at(upper, 2 * i), at(upper, 2 * i + 1), at(lower, 2 * i), at(lower, 2 * i + 1)), one, out + i);
  }
}

void HalveTwoRows(const float* upper, const float* lower, const HalvingKernel& kernel, std::size_t count, float* out) {
  combine_four(upper, lower, count, out, [&](auto d, auto upper_even, auto upper_odd, auto lower_even, auto lower_odd) HWY_ATTR {
    const auto weight = hn::Set(d, kernel.weight[0]);
    const auto even = hn::Mul(weight, hn::Add(upper_even, lower_even));
    const auto odd = hn::Mul(weight, hn::Add(upper_odd, lower_odd));
    return hn::Mul(weight, hn::Add(even, odd));
  });
}

void LeastOfFour(const float* upper, const float* lower, std::size_t count, float* out) {
  combine_four(upper, lower, count, out,
               [](auto, auto a, auto b, auto c, auto e) HWY_ATTR { return hn::Min(hn::Min(a, b), hn::Min(c, e)); });
}

void GreatestOfFour(const float* upper, const float* lower, std::size_t count, float* out) {
  combine_four(upper, lower, count, out,
               [](auto, auto a, auto b, auto c, auto e) HWY_ATTR { return hn::Max(hn::Max(a, b), hn::Max(c, e)); });
}

void LimitToFourRows(const float* const* rows, std::size_t count, float* scratch, float* out) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  // Down the columns first: columns -1 to 2 * count of the fine rows.
  const std::size_t columns = 2 * count + 2;
  float* const least = scratch;
  float* const greatest = scratch + columns;
  std::size_t i = 0;
  for (; i + lanes <= columns; i += lanes) {
    const V a = hn::LoadU(d, rows[0] - 1 + i);
    const V b = hn::LoadU(d, rows[1] - 1 + i);
    const V c = hn::LoadU(d, rows[2] - 1 + i);
    const V e = hn::LoadU(d, rows[3] - 1 + i);
    hn::StoreU(hn::Min(hn::Min(a, b), hn::Min(c, e)), d, least + i);
    hn::StoreU(hn::Max(hn::Max(a, b), hn::Max(c, e)), d, greatest + i);
  }
  for (; i < columns; ++i) {
    float low = rows[0][static_cast<std::ptrdiff_t>(i) - 1];
    float high = low;
    for (int t = 1; t < 4; ++t) {
      const float value = rows[t][static_cast<std::ptrdiff_t>(i) - 1];
      low = value < low ? value : low;
      high = value > high ? value : high;
    }
    least[i] = low;
    greatest[i] = high;
  }
  // Then along the row: fine columns 2x - 1 to 2x + 2 are scratch columns 2x to 2x + 3.
  i = 0;
  for (; i + lanes < count; i += lanes) {
    const auto fold = [&](const float* from, const auto& op) {
      V even;
      V odd;
      V next_even;
      V next_odd;
      hn::LoadInterleaved2(d, from + 2 * i, even, odd);
      hn::LoadInterleaved2(d, from + 2 * i + 2, next_even, next_odd);
      return op(op(even, odd), op(next_even, next_odd));
    };
    const V low = fold(least, [](V a, V b) { return hn::Min(a, b); });
    const V high = fold(greatest, [](V a, V b) { return hn::Max(a, b); });
    hn::StoreU(hn::Min(hn::Max(hn::LoadU(d, out + i), low), high), d, out + i);
  }
  for (; i < count; ++i) {
    float low = least[2 * i];
    float high = greatest[2 * i];
    for (std::size_t t = 1; t < 4; ++t) {
      low = least[2 * i + t] < low ? least[2 * i + t] : low;
      high = greatest[2 * i + t] > high ? greatest[2 * i + t] : high;
    }
    out[i] = out[i] < low ? low : (out[i] > high ? high : out[i]);
  }
}

void CombineRows(const float* const* rows, const HalvingKernel& kernel, std::size_t count, float* out) {
  switch (kernel.taps) {
    case 2:
      return combine<2>(rows, kernel, count, out);
    case 8:
      return combine<8>(rows, kernel, count, out);
    case 12:
      return combine<12>(rows, kernel, count, out);
    default:
      return combine<20>(rows, kernel, count, out);
  }
}

void HalveRow(const float* row, const HalvingKernel& kernel, std::size_t count, float* scratch, float* out) {
  switch (kernel.taps) {
    case 2:
      return halve<2>(row, kernel, count, scratch, out);
    case 8:
      return halve<8>(row, kernel, count, scratch, out);
    case 12:
      return halve<12>(row, kernel, count, scratch, out);
    default:
      return halve<20>(row, kernel, count, scratch, out);
  }
}

void CombinePartialRows(const float* const* weights, std::span<const float* const* const> planes, const HalvingKernel& kernel,
                        std::size_t count, float* const* out) {
  switch (kernel.taps) {
    case 8:
      return combine_partial<8>(weights, planes, kernel, count, out);
    case 12:
      return combine_partial<12>(weights, planes, kernel, count, out);
    default:
      return combine_partial<20>(weights, planes, kernel, count, out);
  }
}

void HalvePartialRow(const float* weights, std::span<const float* const> planes, const HalvingKernel& kernel, std::size_t count,
                     float* scratch, float* const* out) {
  switch (kernel.taps) {
    case 8:
      return halve_partial<8>(weights, planes, kernel, count, scratch, out);
    case 12:
      return halve_partial<12>(weights, planes, kernel, count, scratch, out);
    default:
      return halve_partial<20>(weights, planes, kernel, count, scratch, out);
  }
}

}  // namespace vt::pyramid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::pyramid {

HWY_EXPORT(CombineRows);
HWY_EXPORT(HalveRow);
HWY_EXPORT(HalveTwoRows);
HWY_EXPORT(CombinePartialRows);
HWY_EXPORT(HalvePartialRow);
HWY_EXPORT(LeastOfFour);
HWY_EXPORT(GreatestOfFour);
HWY_EXPORT(LimitToFourRows);

void combine_rows(const float* const* rows, const HalvingKernel& kernel, std::size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(CombineRows)(rows, kernel, count, out);
}

void halve_row(const float* row, const HalvingKernel& kernel, std::size_t count, float* scratch, float* out) {
  HWY_DYNAMIC_DISPATCH(HalveRow)(row, kernel, count, scratch, out);
}

void halve_two_rows(const float* upper, const float* lower, const HalvingKernel& kernel, std::size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(HalveTwoRows)(upper, lower, kernel, count, out);
}

void combine_partial_rows(const float* const* weights, std::span<const float* const* const> planes, const HalvingKernel& kernel,
                          std::size_t count, float* const* out) {
  HWY_DYNAMIC_DISPATCH(CombinePartialRows)(weights, planes, kernel, count, out);
}

void halve_partial_row(const float* weights, std::span<const float* const> planes, const HalvingKernel& kernel, std::size_t count,
                       float* scratch, float* const* out) {
  HWY_DYNAMIC_DISPATCH(HalvePartialRow)(weights, planes, kernel, count, scratch, out);
}

void mean_of_rows(const float* first, const float* second, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = 0.5F * (first[i] + second[i]);
}

void mean_of_pairs(const float* row, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = 0.5F * (row[2 * i] + row[2 * i + 1]);
}

void least_of_four(const float* upper, const float* lower, std::size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(LeastOfFour)(upper, lower, count, out);
}

void greatest_of_four(const float* upper, const float* lower, std::size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(GreatestOfFour)(upper, lower, count, out);
}

void limit_to_four_rows(const float* const* rows, std::size_t count, float* scratch, float* out) {
  HWY_DYNAMIC_DISPATCH(LimitToFourRows)(rows, count, scratch, out);
}

// Not dispatched: sums of doubles in a fixed order, the same on every CPU. Four floats of like size add up in
// a double without rounding.
void remainder_of_four(const PlaneAndRemainder& upper, const PlaneAndRemainder& lower, const float* halved, std::size_t count, float* out) {
  const auto four = [](const float* a, const float* b, std::size_t i) {
    return (static_cast<double>(a[2 * i]) + static_cast<double>(a[2 * i + 1])) +
           (static_cast<double>(b[2 * i]) + static_cast<double>(b[2 * i + 1]));
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double mean = 0.25 * four(upper.plane, lower.plane, i);
    out[i] = static_cast<float>((mean - static_cast<double>(halved[i])) + 0.25 * four(upper.remainder, lower.remainder, i));
  }
}

void pick_first(const float* row, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = row[2 * i];
}

}  // namespace vt::pyramid
#endif
