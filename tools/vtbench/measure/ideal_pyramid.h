// The ruler for overviews: pyramids filtered as well as arithmetic allows, and how far a stored level is from
// them. Whole images in memory, in double precision or better; far too slow to build with, and shares no code
// with what it measures but the sRGB function.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace vt::bench {

// Red, green, blue in linear light, 0..1; ringing may leave that range.
struct LightImage {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::array<std::vector<double>, 3> planes;
};

// `rgb` is width * height sRGB codes, tightly packed.
[[nodiscard]] LightImage light_from_codes(std::span<const std::uint8_t> rgb, std::int64_t width, std::int64_t height);

// Half the width and height (both even) through a brick wall as steep as 64 taps allow: sinc under a Kaiser
// window with beta = 6, so that from 0.88 of the new Nyquist frequency downwards everything passes and from
// 1.12 upwards nothing does, both to 60 dB. Edges are mirrored.
[[nodiscard]] LightImage halve_ideally(const LightImage& fine);

// Weights of the fine texels under and around one coarse texel by the formula that defines the named kernel,
// sum 1; nullopt when there is no formula of that name. "box" is the mean of two, "kaiser3" a sinc under
// Kaiser's window over three coarse texels to each side, alpha 4.
[[nodiscard]] std::optional<std::vector<long double>> kernel_taps(std::string_view name);
// Half the width and height (both even) by `taps` in both directions, long double, nothing rounded on the
// way. Edges are mirrored.
[[nodiscard]] LightImage halve_exactly(const LightImage& fine, std::span<const long double> taps);

// What today's tools do: the mean of four codes, rounded to nearest. For comparison.
[[nodiscard]] std::vector<std::uint8_t> halve_codes(std::span<const std::uint8_t> rgb, std::int64_t width, std::int64_t height);

// Peak 255; infinite when nothing differs. Both are equally long.
[[nodiscard]] double psnr_of_codes_db(std::span<const std::uint8_t> codes, std::span<const std::uint8_t> wanted);

// Sums over texels and channels, from any number of levels.
class PyramidError {
 public:
  // Leaves out `margin` texels along the edges, where kernels of different length must guess differently. The
  // ideal is clamped to 0..1, which is the best that codes can hold.
  void add_level(std::span<const std::uint8_t> rgb, const LightImage& ideal, std::int64_t margin);

  [[nodiscard]] double psnr_linear_db() const;  // peak 1
  [[nodiscard]] double psnr_code_db() const;    // peak 255, against the ideal's unrounded codes
  // By how much mean luminance is off, in percent of the ideal's, on the level where that is worst.
  [[nodiscard]] double worst_drift_percent() const { return worst_drift_percent_; }
  // The largest difference of a code from the ideal's unrounded code; half a code is what rounding alone may
  // cost.
  [[nodiscard]] double worst_code_error() const { return worst_code_error_; }

 private:
  double linear_squares_ = 0.0;
  double code_squares_ = 0.0;
  std::uint64_t samples_ = 0;
  double worst_drift_percent_ = 0.0;
  double worst_code_error_ = 0.0;
};

}  // namespace vt::bench
