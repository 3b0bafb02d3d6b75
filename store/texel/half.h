// IEEE 754 binary16 ("half") to and from binary32, by arithmetic on bits: the same on every CPU, at compile
// time as well. Pure functions, any thread.
#pragma once

#include <bit>
#include <cstdint>

namespace vt {

inline constexpr std::uint16_t kHalfNoData = 0x7E00;  // quiet NaN

// Exact: every half is a float. A NaN keeps its sign and its payload, and becomes quiet.
[[nodiscard]] constexpr float float_from_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16U;
  const std::uint32_t exponent = half >> 10U & 0x1FU;
  const std::uint32_t mantissa = half & 0x3FFU;
  if (exponent == 0x1F) {
    const std::uint32_t quiet = mantissa != 0 ? 0x400000U : 0U;
    return std::bit_cast<float>(sign | 0x7F800000U | quiet | mantissa << 13U);
  }
  if (exponent != 0) return std::bit_cast<float>(sign | (exponent + 127 - 15) << 23U | mantissa << 13U);
  // Zero or subnormal: mantissa * 2^-24, both factors and their product exact.
  const float magnitude = static_cast<float>(mantissa) * 0x1p-24F;
  return sign != 0 ? -magnitude : magnitude;
}

// To nearest, ties to even. From 65520 on, half way between the largest half and what would follow it, the
// result is infinite; up to 2^-25, half the smallest one, it is zero. A NaN keeps its sign and the upper bits
// of its payload, and becomes quiet.
[[nodiscard]] constexpr std::uint16_t half_from_float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16U & 0x8000U;
  const std::uint32_t magnitude = bits & 0x7FFFFFFFU;
  if (magnitude > 0x7F800000U) return static_cast<std::uint16_t>(sign | 0x7E00U | (magnitude >> 13U & 0x3FFU));
  if (magnitude >= 0x47800000U) return static_cast<std::uint16_t>(sign | 0x7C00U);  // 65536 and more

  // How far the mantissa (with its leading one) must move right, and the exponent in the half's terms; the
  // two meet in subnormals, which share the smallest exponent and have no leading one. A mantissa that is
  // rounded up to the next power of two carries into the exponent.
  const std::uint32_t exponent = magnitude >> 23U;
  if (exponent < 127 - 25) return static_cast<std::uint16_t>(sign);  // below 2^-25
  const bool is_normal = exponent > 127 - 15;
  const std::uint32_t shift = is_normal ? 13 : 13 + (127 - 14 - exponent);
  const std::uint32_t mantissa = (magnitude & 0x7FFFFFU) | 0x800000U;
  const std::uint32_t kept = mantissa >> shift;
  const std::uint32_t lost = mantissa & ((1U << shift) - 1U);
  const std::uint32_t tie = 1U << (shift - 1U);
  const std::uint32_t rounded = kept + (lost > tie || (lost == tie && (kept & 1U) != 0) ? 1U : 0U);
  const std::uint32_t base = is_normal ? (exponent - (127 - 15) - 1U) << 10U : 0U;  // the leading one adds one to the exponent
  return static_cast<std::uint16_t>(sign | (base + rounded));
}

}  // namespace vt
