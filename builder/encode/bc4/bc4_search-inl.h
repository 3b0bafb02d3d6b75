// The best fit of one BC4 block: a search of all pairs of end points that could beat a fit that is known.
// Lanes are neighbouring low end points here, not blocks. Included once per SIMD target by bc4_encoder.cpp.
//
// Two bounds keep most pairs away, both never above the true error:
//   * Texels outside the end points: their distance to the nearer end point.
//   * The lattice: the values of a pair lie on a lattice with its step; the least error of the block on any lattice of that step, wherever
//     it starts, bounds all pairs of one distance. On the circle of remainders modulo the step that is the least sum of squares about the
//     mean over the 16 places where the circle can be cut.
// In the mode of six values both count only the texels that are too far from 0 and 255 to be those.
#if defined(VT_BUILDER_ENCODE_BC4_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC4_SEARCH_INL_H_
#undef VT_BUILDER_ENCODE_BC4_SEARCH_INL_H_
#else
#define VT_BUILDER_ENCODE_BC4_SEARCH_INL_H_
#endif

#include <algorithm>
#include <array>

#include "builder/encode/bc4/bc4_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// One block's texels in ascending order, in parts.
using Sorted = std::array<float, 16>;

struct Pair {
  float error;
  int low, high;
  bool six;
};

// Errors are sums of 16 rounded squares: two sums over the same texels, in different orders, differ by less
// than this factor.
constexpr float kSlack = 1.0F + 4e-6F;

// The texels that a bound may count: all, or from `first` to before `last` those that cannot be 0 or 255 in a
// block below `limit`.
struct Counted {
  std::size_t first = 0;
  std::size_t last = 16;
};

HWY_INLINE Counted not_extreme(const Sorted& x, float limit) {
  Counted counted;
  while (counted.first < 16 && x[counted.first] * x[counted.first] <= limit) ++counted.first;
  while (counted.last > counted.first && (kTop - x[counted.last - 1]) * (kTop - x[counted.last - 1]) <= limit) --counted.last;
  return counted;
}

// The largest of 0..255 whose cost, which rises with it and is 0 at 0, is within `limit`.
template <class Cost>
HWY_INLINE int largest_within(float limit, const Cost& cost) {
  int largest = 0;
  for (int bit = 128; bit > 0; bit /= 2)
    if (cost(largest + bit) <= limit) largest += bit;
  return largest;
}

// The highest low end point and the lowest high one for which the texels outside do not cost more than
// `limit`.
HWY_INLINE int highest_low(const Sorted& x, Counted counted, float limit) {
  return largest_within(limit, [&](int code) {
    float cost = 0;
    for (std::size_t i = counted.first; i < counted.last; ++i) {
      const float below = std::max(static_cast<float>(code) * kCode - x[i], 0.0F);
      cost += below * below;
    }
    return cost;
  });
}
HWY_INLINE int lowest_high(const Sorted& x, Counted counted, float limit) {
  return 255 - largest_within(limit, [&](int code_from_top) {
           float cost = 0;
           for (std::size_t i = counted.first; i < counted.last; ++i) {
             const float above = std::max(x[i] - static_cast<float>(255 - code_from_top) * kCode, 0.0F);
             cost += above * above;
           }
           return cost;
         });
}

HWY_INLINE void sort_two(F& p, F& q) {
  const F low = hn::Min(p, q);
  q = hn::Max(p, q);
  p = low;
}

// Least error of the counted texels on lattices whose steps are (first_distance + lane) * unit, less what
// rounding may have added.
HWY_NOINLINE F lattice_bound(const Sorted& x, Counted counted, int first_distance, float unit) {
  const FloatTag f;
  const F zero = hn::Zero(f);
  const F one = constant(1.0F);
  const F step = hn::Mul(hn::Iota(f, static_cast<float>(first_distance)), constant(unit));
  const F per_step = hn::Div(one, hn::Max(step, one));
  const std::size_t n = counted.last - counted.first;
  // Remainders in whole steps; a remainder at either end of 0..1 is the same place on the circle.
  HWY_ALIGN_MAX F r[16];
  for (std::size_t i = 0; i < n; ++i) {
    const F from_lowest = constant(x[counted.first + i] - x[counted.first]);
    r[i] = hn::Mul(hn::Sub(from_lowest, hn::Mul(hn::Floor(hn::Mul(from_lowest, per_step)), step)), per_step);
  }
  // Odd-even merge sort (Batcher), the places past `n` left out: they would hold infinity.
  for (std::size_t p = 1; p < 16; p *= 2)
    for (std::size_t k = p; k >= 1; k /= 2)
      for (std::size_t j = k % p; j + k < 16; j += 2 * k)
        for (std::size_t i = 0; i < k && i + j + k < n; ++i)
          if ((i + j) / (2 * p) == (i + j + k) / (2 * p)) sort_two(r[i + j], r[i + j + k]);

  F sum = zero, squares = zero;
  for (std::size_t i = 0; i < n; ++i) {
    r[i] = hn::Sub(r[i], one);  // so that the sums stay small while the cut moves from -1..0 to 0..1
    sum = hn::Add(sum, r[i]);
    squares = hn::Add(squares, square(r[i]));
  }
  const F per_count = constant(1.0F / static_cast<float>(std::max<std::size_t>(n, 1)));
  F least = hn::Sub(squares, hn::Mul(square(sum), per_count));
  for (std::size_t i = 0; i + 1 < n; ++i) {
    sum = hn::Add(sum, one);
    squares = hn::Add(squares, hn::Add(hn::Add(r[i], r[i]), one));
    least = hn::Min(least, hn::Sub(squares, hn::Mul(square(sum), per_count)));
  }
  // At most 64 roundings of numbers up to 16, 2^-24 of each.
  return hn::Mul(hn::Max(hn::Sub(least, constant(2e-4F)), zero), square(step));
}

// Searches one mode for what has a smaller error than `best`. Of equals the first found stays: the smallest
// distance, then the lowest.
template <bool six>
HWY_NOINLINE void search_mode(const Sorted& x, Pair& best) {
  const FloatTag f;
  constexpr int kLanes = static_cast<int>(kMaxLanes);
  constexpr float kUnit = six ? kFifth : kSeventh;
  // The extremes first: they reject a pair soonest.
  constexpr std::array<std::size_t, 16> kOrder{0, 15, 7, 11, 3, 13, 5, 9, 1, 14, 2, 8, 4, 12, 6, 10};
  const Counted counted = six ? not_extreme(x, best.error) : Counted{};
  const int last_low = highest_low(x, counted, best.error);
  const int first_high = lowest_high(x, counted, best.error);
  const F last_position = constant(six ? 5.0F : 7.0F);

  for (int first_distance = six ? 0 : 1; first_distance < 256; first_distance += kLanes) {
    HWY_ALIGN_MAX float bounds[kMaxLanes];
    hn::Store(lattice_bound(x, counted, first_distance, kUnit), f, bounds);
    for (int distance = first_distance; distance < std::min(first_distance + kLanes, 256); ++distance) {
      if (bounds[distance - first_distance] > best.error) continue;
      const float step_parts = static_cast<float>(distance) * kUnit;
      const F step = constant(step_parts);
      const F per_step = constant(distance == 0 ? 0.0F : 1.0F / step_parts);
      const int end_low = std::min(last_low, 255 - distance);
      for (int low = std::max(first_high - distance, 0); low <= end_low; low += kLanes) {
        const F low_codes = hn::Iota(f, static_cast<float>(low));
        const F origin = hn::Mul(low_codes, constant(kCode));
        const F best_error = constant(best.error);
        F errors = hn::IfThenElseZero(hn::Gt(low_codes, constant(static_cast<float>(end_low))), constant(1e30F));
        for (std::size_t i = 0; i < 16; ++i) {
          const float texel = x[kOrder[i]];
          const F from_origin = hn::Sub(constant(texel), origin);
          const F position = hn::Min(hn::Max(hn::Round(hn::Mul(from_origin, per_step)), hn::Zero(f)), last_position);
          F d = hn::Sub(from_origin, hn::Mul(position, step));
          if constexpr (six) d = hn::Min(hn::Abs(d), constant(std::min(texel, kTop - texel)));
          errors = hn::Add(errors, square(d));
          if (i % 2 == 1 && hn::AllTrue(f, hn::Ge(errors, best_error))) break;
        }
        if (hn::AllTrue(f, hn::Ge(errors, best_error))) continue;
        HWY_ALIGN_MAX float lane_errors[kMaxLanes];
        hn::Store(errors, f, lane_errors);
        for (int lane = 0; lane < kLanes; ++lane)
          if (lane_errors[lane] < best.error)
            best = {.error = lane_errors[lane], .low = low + lane, .high = low + lane + distance, .six = six};
      }
    }
  }
}

// The best of all pairs for every block of the batch. `known` need not be good; the better it is, the shorter
// the search.
HWY_NOINLINE Ends search(const Ends& known, const Texels& texels) {
  const FloatTag f;
  HWY_ALIGN_MAX float low[kMaxLanes];
  HWY_ALIGN_MAX float high[kMaxLanes];
  HWY_ALIGN_MAX float six[kMaxLanes];
  HWY_ALIGN_MAX float error[kMaxLanes];
  hn::Store(known.error, f, error);
  for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
    Sorted x;
    for (std::size_t i = 0; i < 16; ++i) x[i] = texels.x[i][lane];
    std::sort(x.begin(), x.end());
    // A little above what is known, so that it is found again and the order of the search alone decides among
    // equals.
    Pair best{.error = error[lane] * kSlack + 1.0F, .low = 0, .high = 0, .six = true};
    search_mode<false>(x, best);
    search_mode<true>(x, best);
    low[lane] = static_cast<float>(best.low);
    high[lane] = static_cast<float>(best.high);
    six[lane] = best.six ? 1.0F : 0.0F;
    error[lane] = best.error;
  }
  return {.low = hn::Load(f, low), .high = hn::Load(f, high), .six = hn::Gt(hn::Load(f, six), hn::Zero(f)), .error = hn::Load(f, error)};
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // per-target include guard
