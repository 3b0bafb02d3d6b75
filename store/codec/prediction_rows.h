// Rows of values to residuals and back, whatever a value is: what prediction_bytes.cpp, prediction_words.cpp
// and prediction_choice.cpp are built from. Each thread has working memory of its own; otherwise pure
// functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "store/codec/predictor_rules.h"

// Plain loops that the compiler turns into vector instructions, once for every x86-64 and once for those with
// AVX2; the loader of the C library picks one when the program starts. (Before the thread sanitizer has
// started, which therefore has only the first.)
#if defined(__SANITIZE_THREAD__)
#define VT_HAS_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define VT_HAS_THREAD_SANITIZER 1
#endif
#endif
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(VT_HAS_THREAD_SANITIZER)
#define VT_VECTOR_LOOPS __attribute__((target_clones("avx2", "default")))
#else
#define VT_VECTOR_LOOPS
#endif

namespace vt::store {

using Byte = std::uint8_t;

// Working memory of one thread, kept from tile to tile.
template <class T>
T* working_rows(std::size_t count) {
  thread_local std::vector<T> rows;
  if (rows.size() < count) rows.resize(count);
  return rows.data();
}

// Values 1 to `count` - 1 of a row that has one above it.
template <class T, class Rule>
void subtract_rule(const Rule& rule, const T* __restrict above, const T* __restrict now, T* __restrict out, std::size_t count) {
  for (std::size_t x = 1; x < count; ++x) out[x] = minus(now[x], rule(now[x - 1], above[x], above[x - 1]));
}

// What lies outside the tile is taken for the neighbour that does not: in the top row all three are the left
// one, in the first column all three are the upper one. The very first value has no neighbour, and stays as
// it is.
template <class T>
void subtract_row(Predictor predictor, const T* above, const T* now, T* out, std::size_t count) {
  with_rule(predictor, [&](const auto& rule) {
    if (above != nullptr) {
      out[0] = minus(now[0], rule(above[0], above[0], above[0]));
      return subtract_rule(rule, above, now, out, count);
    }
    out[0] = now[0];
    for (std::size_t x = 1; x < count; ++x) out[x] = minus(now[x], rule(now[x - 1], now[x - 1], now[x - 1]));
  });
}

// The other way. `Access` loads and stores the value at a place of a row.
template <class Access, class Rule, class Row>
void add_row(const Rule& rule, const Row* above, const Row* residuals, Row* now, std::size_t count) {
  using T = typename Access::Value;
  T left = Access::load(residuals, 0);
  if (above == nullptr) {
    Access::store(now, 0, left);
    for (std::size_t x = 1; x < count; ++x) {
      left = plus(Access::load(residuals, x), rule(left, left, left));
      Access::store(now, x, left);
    }
    return;
  }
  T corner = Access::load(above, 0);
  left = plus(left, rule(corner, corner, corner));
  Access::store(now, 0, left);
  for (std::size_t x = 1; x < count; ++x) {
    const T up = Access::load(above, x);
    left = plus(Access::load(residuals, x), rule(left, up, corner));
    Access::store(now, x, left);
    corner = up;
  }
}

}  // namespace vt::store
