// RGB9E5: three mantissas of 9 bits (red lowest) and one exponent of 5 bits in 32 bits, as
// GL_EXT_texture_shared_exponent defines it. One exponent for three channels: a channel far below the
// brightest one keeps few bits. Pure functions, any thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace vt::store {

inline constexpr float kRgb9e5Max = 65408.0F;  // 511 / 512 * 2^16

// 2^exponent for a result that is a normal number.
[[nodiscard]] constexpr double rgb9e5_power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52U);
}

// Exact: every code is three floats.
[[nodiscard]] constexpr std::array<float, 3> unpack_rgb9e5(std::uint32_t packed) {
  // The mantissas have no leading one and are fractions of 512; the exponent's bias is 15.
  const double scale = rgb9e5_power_of_two(static_cast<int>(packed >> 27U) - 15 - 9);
  return {static_cast<float>((packed & 511U) * scale), static_cast<float>((packed >> 9U & 511U) * scale),
          static_cast<float>((packed >> 18U & 511U) * scale)};
}

// The section "Encoding" of the extension: the smallest exponent that holds the brightest channel, mantissas
// to nearest, halves up. Negative numbers and NaN become 0, and what is above kRgb9e5Max becomes that.
[[nodiscard]] constexpr std::uint32_t pack_rgb9e5(float red, float green, float blue) {
  // NaN compares false, so it becomes 0 too.
  const auto clamped = [](float value) { return value > 0.0F ? std::min(value, kRgb9e5Max) : 0.0F; };
  const float r = clamped(red);
  const float g = clamped(green);
  const float b = clamped(blue);
  const float brightest = std::max({r, g, b});

  // floor(log2) is the float's own exponent; a subnormal float is far below the least exponent, so its wrong
  // one does not matter.
  const int floor_log2 = static_cast<int>(std::bit_cast<std::uint32_t>(brightest) >> 23U) - 127;
  int exponent = std::max(-15 - 1, floor_log2) + 1 + 15;
  // In double, so that adding a half rounds nothing: the scaled values have 24 bits, and those below 2^-29
  // end up as 0 either way.
  const auto mantissa = [](float value, int e) {
    return static_cast<std::uint32_t>(static_cast<double>(value) * rgb9e5_power_of_two(15 + 9 - e) + 0.5);
  };
  if (mantissa(brightest, exponent) == 512) ++exponent;
  return mantissa(r, exponent) | mantissa(g, exponent) << 9U | mantissa(b, exponent) << 18U | static_cast<std::uint32_t>(exponent) << 27U;
}

}  // namespace vt::store
