// The kernels that make one level from the next finer one. Taps sit at half-integer offsets around the centre of the coarse texel.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace vt::pyramid {

inline constexpr int kMaxTaps = 12;

struct HalvingKernel {
  std::string_view name;
  int taps = 2;  // even; tap t weighs fine texel 2 * i - taps / 2 + 1 + t
  // Symmetric; multiples of 2^-20 with sum exactly 1. So the weights of texels that are all there sum to exactly 1 in any order, and a
  // filtered opaque texel needs no division: the fast path for opaque data and the general path give the same bits.
  std::array<float, kMaxTaps> weight{};

  [[nodiscard]] int reach() const { return taps / 2 - 1; }  // fine texels beyond the two under the coarse one
};

// Mean of the two: exact for energy, associative over levels.
[[nodiscard]] const HalvingKernel& box_kernel();
// Sinc windowed by Kaiser, three coarse texels to each side, alpha = 4: h(x) = sinc(x) I0(4 sqrt(1 - (x/3)^2)) / I0(4).
// Kaiser & Kuo 1966; the pass band is flat and 4.5 dB less aliases get through than with the box.
[[nodiscard]] const HalvingKernel& kaiser3_kernel();
[[nodiscard]] std::optional<HalvingKernel> kernel_from_name(std::string_view name);  // "box", "kaiser3"

}  // namespace vt::pyramid
