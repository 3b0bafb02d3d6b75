// The sRGB transfer function of IEC 61966-2-1 and exact tables for 8-bit codes. Pure, any thread.
#pragma once

#include <array>
#include <bit>
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

// Light of each 8-bit code, and the way back: the code whose light is nearest. Light is what has to be kept,
// and codes are closer together in the dark: the nearest place on the code axis would round the mean of two
// codes up more often than down, and brighten dark pictures by percents. Light half way between two codes to
// within two floats, as means of two and of four texels often are, becomes the upper one in even columns and
// the lower one in odd ones, so that as much is rounded up as down and a picture of nothing else keeps its
// mean.
//
// Going back needs no power function. Code c begins half way between the lights of c - 1 and c. No two
// beginnings are closer than 1 / (255 * 12.92) = 1 / 3294.6, so each of 4096 equal bins of light holds at
// most one of them: the bin gives the code at its lower edge, one comparison decides the rest. A code begins
// two floats lower than half way, in odd columns two higher.
class CodeTable {
 public:
  explicit CodeTable(Transfer transfer) {
    for (int c = 0; c < 256; ++c) light_[static_cast<std::size_t>(c)] = static_cast<float>(linear_from_code(transfer, c / 255.0));
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    begin_[0] = -kInfinity;
    for (std::size_t c = 1; c < 256; ++c) begin_[c] = moved(0.5F * (light_[c - 1] + light_[c]), -kTieFloats);
    begin_[256] = moved(std::numeric_limits<float>::max(), -2 * kTieFloats);  // has floats after it
    int code = 0;
    for (int bin = 0; bin <= kBins; ++bin) {
      // A code that begins on the bin's own edge is left to the comparison, in which columns differ.
      while (moved(begin_[static_cast<std::size_t>(code) + 1], 2 * kTieFloats) < static_cast<float>(bin) / kBins) ++code;
      code_at_bin_[static_cast<std::size_t>(bin)] = code;
      next_begin_at_bin_[static_cast<std::size_t>(bin)] = begin_[static_cast<std::size_t>(code) + 1];
    }
  }

  [[nodiscard]] float light(std::uint8_t code) const { return light_[code]; }
  [[nodiscard]] const std::array<float, 256>& light_table() const { return light_; }

  // Any float; below 0 and NaN give 0, above 1 gives 255. `column` of the texel: only whether it is odd
  // matters.
  [[nodiscard]] std::uint8_t code(float light, std::int64_t column) const {
    const float clamped = light > 0.0F ? (light < 1.0F ? light : 1.0F) : 0.0F;
    const auto bin = static_cast<std::size_t>(clamped * kBins);
    const float begin = moved(next_begin_at_bin_[bin], (column & 1) != 0 ? 2 * kTieFloats : 0);
    return static_cast<std::uint8_t>(code_at_bin_[bin] + (clamped >= begin ? 1 : 0));
  }

  // The tables behind code(), for row loops: kBins + 1 entries each; in odd columns a code begins 2 *
  // kTieFloats later.
  static constexpr int kBins = 4096;
  static constexpr int kTieFloats = 2;
  [[nodiscard]] const std::int32_t* code_at_bin() const { return code_at_bin_.data(); }
  [[nodiscard]] const float* next_begin_at_bin() const { return next_begin_at_bin_.data(); }

 private:
  // So many floats up or down. Positive ones are in the order of their bits.
  static float moved(float positive, int floats) { return std::bit_cast<float>(std::bit_cast<std::int32_t>(positive) + floats); }

  std::array<float, 256> light_;
  std::array<float, 257> begin_;
  std::array<std::int32_t, kBins + 1> code_at_bin_;  // at the bin's lower edge
  std::array<float, kBins + 1> next_begin_at_bin_;   // where the code after that begins
};

// One table per transfer function, made on first use.
[[nodiscard]] const CodeTable& code_table(Transfer transfer);

}  // namespace vt::channels
