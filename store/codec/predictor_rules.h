// What each predictor foretells of a value from its three neighbours, once, for every kind of value that the
// encoder and the decoder work on: bytes, 16- and 32-bit integers, and pixels of four bytes at a time. Pure
// functions, any thread. For prediction*.cpp and their tests.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "store/codec/prediction.h"

namespace vt::store {

// ---- Arithmetic modulo 2^8, 2^16 or 2^32 ----

template <std::unsigned_integral T>
[[nodiscard]] constexpr T plus(T a, T b) {
  return static_cast<T>(a + b);
}
template <std::unsigned_integral T>
[[nodiscard]] constexpr T minus(T a, T b) {
  return static_cast<T>(a - b);
}
// (a + b + 1) / 2 without overflow.
template <std::unsigned_integral T>
[[nodiscard]] constexpr T average(T a, T b) {
  return static_cast<T>((a | b) - ((a ^ b) >> 1));
}
template <std::unsigned_integral T>
[[nodiscard]] constexpr T least(T a, T b) {
  return a < b ? a : b;
}
template <std::unsigned_integral T>
[[nodiscard]] constexpr T greatest(T a, T b) {
  return a < b ? b : a;
}

// Four bytes that are worked on side by side: the channels of a texel, of which each waits for its own left
// neighbour.
#if defined(__SSE2__)
struct Pixel {
  __m128i lanes;

  [[nodiscard]] static Pixel zero() { return {_mm_setzero_si128()}; }
  [[nodiscard]] static Pixel load(const std::uint8_t* bytes) {
    int four = 0;
    std::memcpy(&four, bytes, sizeof four);
    return {_mm_cvtsi32_si128(four)};
  }
  void store(std::uint8_t* bytes) const {
    const int four = _mm_cvtsi128_si32(lanes);
    std::memcpy(bytes, &four, sizeof four);
  }
};
[[nodiscard]] inline Pixel plus(Pixel a, Pixel b) { return {_mm_add_epi8(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel minus(Pixel a, Pixel b) { return {_mm_sub_epi8(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel average(Pixel a, Pixel b) { return {_mm_avg_epu8(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel least(Pixel a, Pixel b) { return {_mm_min_epu8(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel greatest(Pixel a, Pixel b) { return {_mm_max_epu8(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel operator&(Pixel a, Pixel b) { return {_mm_and_si128(a.lanes, b.lanes)}; }
[[nodiscard]] inline Pixel operator|(Pixel a, Pixel b) { return {_mm_or_si128(a.lanes, b.lanes)}; }
#else
struct Pixel {
  std::array<std::uint8_t, 4> lanes;

  [[nodiscard]] static Pixel zero() { return {}; }
  [[nodiscard]] static Pixel load(const std::uint8_t* bytes) { return {{bytes[0], bytes[1], bytes[2], bytes[3]}}; }
  void store(std::uint8_t* bytes) const { std::copy(lanes.begin(), lanes.end(), bytes); }
};
template <class Operation>
[[nodiscard]] inline Pixel lane_by_lane(Pixel a, Pixel b, Operation operation) {
  for (std::size_t i = 0; i < a.lanes.size(); ++i) a.lanes[i] = operation(a.lanes[i], b.lanes[i]);
  return a;
}
using Byte = std::uint8_t;
[[nodiscard]] inline Pixel plus(Pixel a, Pixel b) { return lane_by_lane(a, b, plus<Byte>); }
[[nodiscard]] inline Pixel minus(Pixel a, Pixel b) { return lane_by_lane(a, b, minus<Byte>); }
[[nodiscard]] inline Pixel average(Pixel a, Pixel b) { return lane_by_lane(a, b, average<Byte>); }
[[nodiscard]] inline Pixel least(Pixel a, Pixel b) { return lane_by_lane(a, b, least<Byte>); }
[[nodiscard]] inline Pixel greatest(Pixel a, Pixel b) { return lane_by_lane(a, b, greatest<Byte>); }
[[nodiscard]] inline Pixel operator&(Pixel a, Pixel b) {
  return lane_by_lane(a, b, [](Byte x, Byte y) { return static_cast<Byte>(x & y); });
}
[[nodiscard]] inline Pixel operator|(Pixel a, Pixel b) {
  return lane_by_lane(a, b, [](Byte x, Byte y) { return static_cast<Byte>(x | y); });
}
#endif

// ---- The predictors: `left`, `up` and `corner` (above the left one) are the neighbours ----

struct PredictNone {
  template <class T>
  [[nodiscard]] T operator()(T left, T, T) const {
    return minus(left, left);
  }
};
struct PredictLeft {
  template <class T>
  [[nodiscard]] T operator()(T left, T, T) const {
    return left;
  }
};
struct PredictUp {
  template <class T>
  [[nodiscard]] T operator()(T, T up, T) const {
    return up;
  }
};
struct PredictAverage {
  template <class T>
  [[nodiscard]] T operator()(T left, T up, T) const {
    return average(left, up);
  }
};
struct PredictGradient {
  template <class T>
  [[nodiscard]] T operator()(T left, T up, T corner) const {
    return minus(plus(left, up), corner);
  }
};
// The median of left, up and their gradient, as in LOCO-I (Weinberger, Seroussi, Sapiro 2000), in a form that
// cannot overflow: a corner beyond both neighbours is taken for the nearer of them.
struct PredictMedian {
  template <class T>
  [[nodiscard]] T operator()(T left, T up, T corner) const {
    const T inside = greatest(least(left, up), least(greatest(left, up), corner));
    return minus(plus(left, up), inside);
  }
};

// Calls `use` with the rule of a predictor.
template <class Use>
void with_rule(Predictor predictor, Use&& use) {
  switch (predictor) {
    case Predictor::kNone:
      return use(PredictNone());
    case Predictor::kLeft:
      return use(PredictLeft());
    case Predictor::kUp:
      return use(PredictUp());
    case Predictor::kAverage:
      return use(PredictAverage());
    case Predictor::kGradient:
      return use(PredictGradient());
    case Predictor::kMedian:
      return use(PredictMedian());
  }
}

}  // namespace vt::store
