#include "tools/vtbench/measure/ideal_pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "builder/channels/shared/srgb.h"

namespace vt::bench {
namespace {

constexpr int kTaps = 64;
std::vector<double> ideal_weights() {
  constexpr double kBeta = 6.0;
  std::vector<double> weights(kTaps);
  double sum = 0.0;
  for (int t = 0; t < kTaps; ++t) {
    const double offset = t - (kTaps - 1) / 2.0;  // fine texels from the centre of the coarse one
    const double phase = std::numbers::pi * offset / 2.0;
    const double edge = offset / (kTaps / 2.0);
    const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - edge * edge)) / std::cyl_bessel_i(0.0, kBeta);
    weights[static_cast<std::size_t>(t)] = std::sin(phase) / phase * window;
    sum += weights[static_cast<std::size_t>(t)];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// Reflects about the edges (…1 0 | 0 1 2…), as often as a short line needs.
std::int64_t mirrored(std::int64_t i, std::int64_t count) {
  const std::int64_t period = 2 * count;
  i = ((i % period) + period) % period;
  return i < count ? i : period - 1 - i;
}

// `lines` lines of `length` values; value i of line n is at n * line_step + i * value_step. Sums are of the
// weights' type.
template <class Real>
void halve_lines(const std::vector<double>& in, std::int64_t lines, std::int64_t length, std::int64_t in_line, std::int64_t in_step,
                 std::vector<double>& out, std::int64_t out_line, std::int64_t out_step, std::span<const Real> weights) {
  const std::int64_t reach = static_cast<std::int64_t>(weights.size()) / 2 - 1;
  std::vector<double> padded(static_cast<std::size_t>(length + 2 * reach));
  for (std::int64_t n = 0; n < lines; ++n) {
    for (std::int64_t i = 0; i < length + 2 * reach; ++i)
      padded[static_cast<std::size_t>(i)] = in[static_cast<std::size_t>(n * in_line + mirrored(i - reach, length) * in_step)];
    for (std::int64_t i = 0; i < length / 2; ++i) {
      Real sum = 0;
      for (std::size_t t = 0; t < weights.size(); ++t) sum += weights[t] * static_cast<Real>(padded[static_cast<std::size_t>(2 * i) + t]);
      out[static_cast<std::size_t>(n * out_line + i * out_step)] = static_cast<double>(sum);
    }
  }
}

template <class Real>
LightImage halve(const LightImage& fine, std::span<const Real> weights) {
  assert(fine.width % 2 == 0 && fine.height % 2 == 0);
  LightImage coarse{fine.width / 2, fine.height / 2, {}};
  std::vector<double> narrow(static_cast<std::size_t>(coarse.width * fine.height));
  for (std::size_t p = 0; p < 3; ++p) {
    coarse.planes[p].resize(static_cast<std::size_t>(coarse.width * coarse.height));
    halve_lines(fine.planes[p], fine.height, fine.width, fine.width, 1, narrow, coarse.width, 1, weights);
    halve_lines(narrow, coarse.width, fine.height, 1, coarse.width, coarse.planes[p], 1, coarse.width, weights);
  }
  return coarse;
}

double decibels(double squares, std::uint64_t samples, double peak) {
  if (squares == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(peak * peak * static_cast<double>(samples) / squares);
}

std::array<double, 256> light_of_codes() {
  std::array<double, 256> light{};
  for (std::size_t code = 0; code < 256; ++code) light[code] = channels::linear_from_srgb(static_cast<double>(code) / 255.0);
  return light;
}

}  // namespace

LightImage light_from_codes(std::span<const std::uint8_t> rgb, std::int64_t width, std::int64_t height) {
  const auto texels = static_cast<std::size_t>(width * height);
  assert(rgb.size() == texels * 3);
  const std::array<double, 256> light = light_of_codes();
  LightImage image{width, height, {}};
  for (std::size_t p = 0; p < 3; ++p) {
    image.planes[p].resize(texels);
    for (std::size_t i = 0; i < texels; ++i) image.planes[p][i] = light[rgb[i * 3 + p]];
  }
  return image;
}

LightImage halve_ideally(const LightImage& fine) {
  static const std::vector<double> weights = ideal_weights();
  return halve<double>(fine, weights);
}

std::optional<std::vector<long double>> kernel_taps(std::string_view name) {
  if (name == "box") return std::vector<long double>{0.5L, 0.5L};
  if (name != "kaiser3") return std::nullopt;
  constexpr int kCount = 12;
  std::vector<long double> taps;
  for (int t = 0; t < kCount; ++t) {
    const long double x = (static_cast<long double>(t) - (kCount - 1) / 2.0L) / 2.0L;  // coarse texels from the centre
    const long double phase = std::numbers::pi_v<long double> * x;
    const long double window = std::cyl_bessel_i(0.0L, 4.0L * std::sqrt(1.0L - x * x / 9.0L)) / std::cyl_bessel_i(0.0L, 4.0L);
    taps.push_back(std::sin(phase) / phase * window);
  }
  long double sum = 0.0L;
  for (const long double tap : taps) sum += tap;
  for (long double& tap : taps) tap /= sum;
  return taps;
}

LightImage halve_exactly(const LightImage& fine, std::span<const long double> taps) { return halve<long double>(fine, taps); }

std::vector<std::uint8_t> halve_codes(std::span<const std::uint8_t> rgb, std::int64_t width, std::int64_t height) {
  std::vector<std::uint8_t> coarse(static_cast<std::size_t>(width / 2 * (height / 2) * 3));
  const auto code = [&](std::int64_t x, std::int64_t y, std::int64_t p) {
    return int{rgb[static_cast<std::size_t>((y * width + x) * 3 + p)]};
  };
  auto out = coarse.begin();
  for (std::int64_t y = 0; y < height / 2; ++y)
    for (std::int64_t x = 0; x < width / 2; ++x)
      for (std::int64_t p = 0; p < 3; ++p)
        *out++ = static_cast<std::uint8_t>(
            (code(2 * x, 2 * y, p) + code(2 * x + 1, 2 * y, p) + code(2 * x, 2 * y + 1, p) + code(2 * x + 1, 2 * y + 1, p) + 2) / 4);
  return coarse;
}

double psnr_of_codes_db(std::span<const std::uint8_t> codes, std::span<const std::uint8_t> wanted) {
  assert(codes.size() == wanted.size());
  double squares = 0.0;
  for (std::size_t i = 0; i < codes.size(); ++i) squares += (codes[i] - wanted[i]) * (codes[i] - wanted[i]);
  return decibels(squares, codes.size(), 255.0);
}

void PyramidError::add_level(std::span<const std::uint8_t> rgb, const LightImage& ideal, std::int64_t margin) {
  assert(rgb.size() == static_cast<std::size_t>(ideal.width * ideal.height * 3));
  constexpr std::array kLuminance = {0.2126, 0.7152, 0.0722};  // ITU-R BT.709
  const std::array<double, 256> light = light_of_codes();
  double luminance = 0.0;
  double ideal_luminance = 0.0;
  for (std::int64_t y = margin; y < ideal.height - margin; ++y)
    for (std::int64_t x = margin; x < ideal.width - margin; ++x) {
      const auto texel = static_cast<std::size_t>(y * ideal.width + x);
      for (std::size_t p = 0; p < 3; ++p) {
        const std::uint8_t code = rgb[texel * 3 + p];
        const double wanted = std::clamp(ideal.planes[p][texel], 0.0, 1.0);
        const double linear_error = light[code] - wanted;
        const double code_error = code - 255.0 * channels::srgb_from_linear(wanted);
        linear_squares_ += linear_error * linear_error;
        code_squares_ += code_error * code_error;
        worst_code_error_ = std::max(worst_code_error_, std::abs(code_error));
        luminance += kLuminance[p] * light[code];
        ideal_luminance += kLuminance[p] * wanted;
        ++samples_;
      }
    }
  if (ideal_luminance > 0.0) {
    const double drift = 100.0 * (luminance / ideal_luminance - 1.0);
    if (std::abs(drift) > std::abs(worst_drift_percent_)) worst_drift_percent_ = drift;
  }
}

double PyramidError::psnr_linear_db() const { return decibels(linear_squares_, samples_, 1.0); }
double PyramidError::psnr_code_db() const { return decibels(code_squares_, samples_, 255.0); }

}  // namespace vt::bench
