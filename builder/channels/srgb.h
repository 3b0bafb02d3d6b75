// The sRGB transfer function of IEC 61966-2-1 and exact tables for 8-bit codes. Pure, any thread.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "store/channel.h"

namespace vt::channels {

// Light of a code, both 0..1.
[[nodiscard]] inline double linear_from_srgb(double code) { return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4); }
[[nodiscard]] inline double srgb_from_linear(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}
[[nodiscard]] inline double linear_from_code(Transfer transfer, double code) {
  return transfer == Transfer::kSrgb ? linear_from_srgb(code) : code;
}

// Light of each 8-bit code, and the way back: the code whose light is nearest on the code axis, exactly.
//
// Going back needs no power function. Code c begins at the light of c - 1/2. No two beginnings are closer than 1 / (255 * 12.92) = 1 /
// 3294.6, so each of 4096 equal bins of light holds at most one of them: the bin gives the code at its lower edge, one comparison decides
// the rest.
class CodeTable {
 public:
  explicit CodeTable(Transfer transfer) {
    for (int c = 0; c < 256; ++c) light_[static_cast<std::size_t>(c)] = static_cast<float>(linear_from_code(transfer, c / 255.0));
    begin_[0] = -std::numeric_limits<float>::infinity();
    for (int c = 1; c < 256; ++c) begin_[static_cast<std::size_t>(c)] = static_cast<float>(linear_from_code(transfer, (c - 0.5) / 255.0));
    begin_[256] = std::numeric_limits<float>::infinity();
    int code = 0;
    for (int bin = 0; bin <= kBins; ++bin) {
      while (begin_[static_cast<std::size_t>(code) + 1] <= static_cast<float>(bin) / kBins) ++code;
      code_at_bin_[static_cast<std::size_t>(bin)] = code;
      next_begin_at_bin_[static_cast<std::size_t>(bin)] = begin_[static_cast<std::size_t>(code) + 1];
    }
  }

  [[nodiscard]] float light(std::uint8_t code) const { return light_[code]; }
  [[nodiscard]] const std::array<float, 256>& light_table() const { return light_; }

  // Any float; below 0 and NaN give 0, above 1 gives 255.
  [[nodiscard]] std::uint8_t code(float light) const {
    const float clamped = light > 0.0F ? (light < 1.0F ? light : 1.0F) : 0.0F;
    const auto bin = static_cast<std::size_t>(clamped * kBins);
    return static_cast<std::uint8_t>(code_at_bin_[bin] + (clamped >= next_begin_at_bin_[bin] ? 1 : 0));
  }

  // The tables behind code(), for row loops: kBins + 1 entries each.
  static constexpr int kBins = 4096;
  [[nodiscard]] const std::int32_t* code_at_bin() const { return code_at_bin_.data(); }
  [[nodiscard]] const float* next_begin_at_bin() const { return next_begin_at_bin_.data(); }

 private:
  std::array<float, 256> light_;
  std::array<float, 257> begin_;
  std::array<std::int32_t, kBins + 1> code_at_bin_;  // at the bin's lower edge
  std::array<float, kBins + 1> next_begin_at_bin_;   // where the code after that begins
};

// One table per transfer function, made on first use.
[[nodiscard]] const CodeTable& code_table(Transfer transfer);

}  // namespace vt::channels
