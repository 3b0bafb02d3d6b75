// The inner loops of every overview: weighted sums of rows and along a row, extremes, single texels. SIMD with run-time dispatch; products
// and sums are rounded one by one in one fixed order, so that every CPU and every blocking gives the same bits. Any thread.
#pragma once

#include <cstddef>
#include <span>

#include "builder/pyramid/halving_kernel.h"

namespace vt::pyramid {

// out[i] = sum over t of kernel.weight[t] * rows[t][i], taken in symmetric pairs from the outside in: w0 * (r0 + rN) + w1 * (r1 + rN-1) +
// ... `rows` has kernel.taps pointers. Buffers may be unaligned; `out` overlaps none of them.
void combine_rows(const float* const* rows, const HalvingKernel& kernel, std::size_t count, float* out);

// out[i] = sum over t of kernel.weight[t] * row[2 * i - kernel.reach() + t], paired in the same way. `row` is readable from -reach() - 1 to
// 2 * count + reach() + 1. `scratch` holds at least halve_scratch_floats(count) floats.
void halve_row(const float* row, const HalvingKernel& kernel, std::size_t count, float* scratch, float* out);
// Both at once for a kernel of two taps: the same roundings in the same order as combine_rows and halve_row, without the rows between.
// out[i] comes from both rows at 2 * i and 2 * i + 1.
void halve_two_rows(const float* upper, const float* lower, const HalvingKernel& kernel, std::size_t count, float* out);

// out[i] = the least (greatest) of both rows at 2 * i and 2 * i + 1. No value is NaN.
void least_of_four(const float* upper, const float* lower, std::size_t count, float* out);
void greatest_of_four(const float* upper, const float* lower, std::size_t count, float* out);

// Moves out[i] between the least and the greatest of four rows at 2 * i - 1 to 2 * i + 2, which are readable from -1 to 2 * count.
// `scratch` holds 4 * count + 4 floats.
void limit_to_four_rows(const float* const* rows, std::size_t count, float* scratch, float* out);

// out[i] = row[2 * i].
void pick_first(const float* row, std::size_t count, float* out);

[[nodiscard]] constexpr std::size_t halve_scratch_floats(std::size_t count) { return 2 * (count + 64); }

}  // namespace vt::pyramid
