// The inner loops of every overview: weighted sums of rows and along a row, extremes, single texels. SIMD
// with run-time dispatch; products and sums are rounded one by one in one fixed order, so that every CPU and
// every blocking gives the same bits. Any thread.
#pragma once

#include <cstddef>
#include <span>

#include "builder/pyramid/halving_kernel.h"

namespace vt::pyramid {

// out[i] = sum over t of kernel.weight[t] * rows[t][i], taken in symmetric pairs from the outside in: w0 *
// (r0 + rN) + w1 * (r1 + rN-1) + ... `rows` has kernel.taps pointers. Buffers may be unaligned; `out`
// overlaps none of them.
void combine_rows(const float* const* rows, const HalvingKernel& kernel, std::size_t count, float* out);

// out[i] = sum over t of kernel.weight[t] * row[2 * i - kernel.reach() + t], paired in the same way. `row` is
// readable from -reach() - 1 to 2 * count + reach() + 1. `scratch` holds at least halve_scratch_floats(count)
// floats.
void halve_row(const float* row, const HalvingKernel& kernel, std::size_t count, float* scratch, float* out);
// Both at once for a kernel of two taps: the same roundings in the same order as combine_rows and halve_row,
// without the rows between. out[i] comes from both rows at 2 * i and 2 * i + 1.
void halve_two_rows(const float* upper, const float* lower, const HalvingKernel& kernel, std::size_t count, float* out);

// What the two above become where texels are not all there: weights below 1, or none at all. A plane's values
// are multiplied by their weights; the coarse texel's weight is the mean of the two fine ones under it,
// whatever the kernel, for that is how much of its area has data. Each of the other taps exchanges value with
// one of these two, the one that lies mirrored to it about the edge between their coarse texels: the first of
// the two for taps an odd number of texels away from it, the second for the others. As much is exchanged as
// both have:
//   out = (p0 + p1) / 2 + sum over t of weight[t] * min(m_t, m_q) * (p_t / m_t - p_q / m_q)        q = 0 or 1, the partner of tap t
// with p / m = 0 where m = 0. The mirrored coarse texel takes the same with the opposite sign. So sums of
// values and of weights are those of the finer level to rounding, a constant stays constant, nothing is
// divided by less than what it is made of, texels without data neither give nor get, and where all weights
// are 1 this is the kernel.
//
// combine_partial_rows: writes out[p][i] where some weight under the taps at i is not 1, and leaves the
// others as combine_rows made them. `weights` has kernel.taps rows, each of `planes` as well; weights are 0
// to 1, values without weight are 0.
void combine_partial_rows(const float* const* weights, std::span<const float* const* const> planes, const HalvingKernel& kernel,
                          std::size_t count, float* const* out);
// halve_partial_row: the same along a row, after halve_row. Rows are readable as there; `scratch` holds
// planes.size() + 1 times what halve_row needs.
void halve_partial_row(const float* weights, std::span<const float* const> planes, const HalvingKernel& kernel, std::size_t count,
                       float* scratch, float* const* out);
// out[i] = (first[i] + second[i]) / 2, and the mean of row[2 * i] and row[2 * i + 1].
void mean_of_rows(const float* first, const float* second, std::size_t count, float* out);
void mean_of_pairs(const float* row, std::size_t count, float* out);

// out[i] = the least (greatest) of both rows at 2 * i and 2 * i + 1. No value is NaN.
void least_of_four(const float* upper, const float* lower, std::size_t count, float* out);
void greatest_of_four(const float* upper, const float* lower, std::size_t count, float* out);

// Moves out[i] between the least and the greatest of four rows at 2 * i - 1 to 2 * i + 2, which are readable
// from -1 to 2 * count. `scratch` holds 4 * count + 4 floats.
void limit_to_four_rows(const float* const* rows, std::size_t count, float* scratch, float* out);

// What rounding takes from halve_two_rows() with weights of a half, in double precision: out[i] = the mean of
// the four fine values, each plane + remainder, less `halved[i]`. All rows are as of halve_two_rows(),
// `halved` is what it made of the plane.
struct PlaneAndRemainder {
  const float* plane;
  const float* remainder;
};
void remainder_of_four(const PlaneAndRemainder& upper, const PlaneAndRemainder& lower, const float* halved, std::size_t count, float* out);

// out[i] = row[2 * i].
void pick_first(const float* row, std::size_t count, float* out);

[[nodiscard]] constexpr std::size_t halve_scratch_floats(std::size_t count) { return 2 * (count + 64); }

}  // namespace vt::pyramid
