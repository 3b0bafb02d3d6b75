// Numbers of a known range as codes of an unorm or block format: what the builder writes and the range by
// which readers get it back are made in one place. Pure functions, any thread.
#pragma once

#include <cassert>
#include <cstdint>

#include "store/layer.h"
#include "store/texel_format.h"

namespace vt::channels {

// The samples of bc1 to bc5 and bc7 run from 0 to 255 with fractions between; their encoders for one and two
// channels take 257 steps a code.
struct UnormCode {
  float low = 0.0F;  // values outside are clamped
  float high = 1.0F;
  float gain = 1.0F;
  float bias = 0.5F;  // with the half that rounds to nearest
  ComponentRange range;

  // The code in a texel of unblocked_format(). `value` is not NaN.
  [[nodiscard]] std::uint16_t code(float value) const {
    const float clamped = value > low ? (value < high ? value : high) : low;
    return static_cast<std::uint16_t>(clamped * gain + bias);
  }
  // What a sample that was read back is worth.
  [[nodiscard]] double value(float sample) const { return range.offset + range.scale * static_cast<double>(sample); }
  [[nodiscard]] double step() const { return range.scale; }
};

// Code `first` (0 or 1) stands for `low`, the largest code for `high`. With 1 the number of codes is odd, so
// the middle of the range is decoded exactly; code 0 is then free to mean that there is no data.
[[nodiscard]] inline UnormCode unorm_code(TexelFormat format, double low, double high, int first) {
  const SampleKind samples = format_info(format).samples;
  assert(greatest_code(samples) > 0 && "samples are codes");
  const double last = greatest_code(samples);
  const double steps_per_sample = samples == SampleKind::kBlock ? 257.0 : 1.0;
  const double gain = steps_per_sample * (last - first) / (high - low);
  const double middle = 0.5 * (first + last);
  UnormCode code;
  code.low = static_cast<float>(low);
  code.high = static_cast<float>(high);
  code.gain = static_cast<float>(gain);
  code.bias = static_cast<float>(steps_per_sample * middle - gain * 0.5 * (low + high) + 0.5);
  // From the middle, whose code is a power of two when `first` is 1: then scale * middle is exact and a
  // middle of 0 comes back as 0.
  code.range.scale = (high - low) / (last - first);
  code.range.offset = 0.5 * (low + high) - middle * code.range.scale;
  return code;
}

}  // namespace vt::channels
