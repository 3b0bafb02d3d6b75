// The kernels that make one level from the next finer one. Taps sit at half-integer offsets around the centre
// of the coarse texel.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace vt::pyramid {

inline constexpr int kMaxTaps = 20;

struct HalvingKernel {
  std::string_view name;
  int taps = 2;  // even; tap t weighs fine texel 2 * i - taps / 2 + 1 + t
  // Symmetric; multiples of 2^-20 with sum exactly 1. So the weights of texels that are all there sum to
  // exactly 1 in any order, and a filtered opaque texel needs no division: the fast path for opaque data and
  // the general path give the same bits.
  std::array<float, kMaxTaps> weight{};
  // Not a mean: the coarse texel is the fine texel 2 * i. Then texel i of a level lies at the place of texel
  // 2 * i of the next finer one, and neighbouring tiles share their edges at every level, as displaced
  // surfaces need.
  bool is_point = false;
  bool limits_ringing = false;  // values stay within the texels under the main lobe

  [[nodiscard]] int reach() const { return taps / 2 - 1; }  // fine texels beyond the two under the coarse one
  [[nodiscard]] bool has_negative_lobes() const;
};

// Mean of the two: exact for energy, associative over levels.
[[nodiscard]] const HalvingKernel& box_kernel();
// Sinc windowed by Kaiser, three coarse texels to each side, alpha = 4: h(x) = sinc(x) I0(4 sqrt(1 -
// (x/3)^2)) / I0(4). Kaiser & Kuo 1966; the pass band is flat and 4.5 dB less aliases get through than with
// the box.
[[nodiscard]] const HalvingKernel& kaiser3_kernel();
// The same with five coarse texels to each side: another 2.3 dB for 20 taps instead of 12.
[[nodiscard]] const HalvingKernel& kaiser5_kernel();
// sinc(x) sinc(x/3). Duchon 1979.
[[nodiscard]] const HalvingKernel& lanczos3_kernel();
// The cubic with B = C = 1/3 of Mitchell & Netravali 1988: little ringing (1.9 %), softer.
[[nodiscard]] const HalvingKernel& mitchell_kernel();
// Takes one texel of four; for heights that displace.
[[nodiscard]] const HalvingKernel& point_kernel();

[[nodiscard]] std::span<const HalvingKernel> all_kernels();
[[nodiscard]] std::optional<HalvingKernel> kernel_from_name(std::string_view name);

}  // namespace vt::pyramid
