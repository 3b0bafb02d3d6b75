// Heights as numbers of a texel format: to nearest, and outward for bounds. Each form says of a height
// whether it can hold it; none clamps. Pure functions, any thread. Private to
// builder/channels/elevation/elevation.cpp.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "store/texel/half.h"

namespace vt::channels {

// Every form: `Sample` is what is stored, kNone what means "no data". nearest(), below() and above() give the
// nearest sample, the greatest that is not above the height and the least that is not below it; false: there
// is none, `out` is kNone. Heights are floats or doubles. from(origin) takes heights less `origin`, which
// only codes can.

struct FloatHeights {
  using Sample = float;
  static constexpr Sample kNone = std::numeric_limits<float>::quiet_NaN();

  template <class Height>
  [[nodiscard]] static bool nearest(Height height, Sample& out) {
    // Finite: not so when sums of huge samples overflowed.
    const bool holds = std::abs(height) <= static_cast<Height>(std::numeric_limits<float>::max());
    out = holds ? static_cast<float>(height) : kNone;
    return holds;
  }
  [[nodiscard]] static bool below(float height, Sample& out) { return nearest(height, out); }
  [[nodiscard]] static bool above(float height, Sample& out) { return nearest(height, out); }
  [[nodiscard]] static FloatHeights from(double) { return {}; }
};

struct HalfHeights {
  using Sample = std::uint16_t;
  static constexpr Sample kNone = kHalfNoData;
  static constexpr float kLargest = 65504.0F;

  template <class Height>
  [[nodiscard]] static bool nearest(Height height, Sample& out) {
    const bool holds = std::abs(height) <= static_cast<Height>(kLargest);
    out = holds ? half_from_float(static_cast<float>(height)) : kNone;
    return holds;
  }
  [[nodiscard]] static bool below(float height, Sample& out) {
    if (!nearest(height, out)) return false;
    if (float_from_half(out) > height) out = next(out, -1);
    return true;
  }
  [[nodiscard]] static bool above(float height, Sample& out) {
    if (!nearest(height, out)) return false;
    if (float_from_half(out) < height) out = next(out, 1);
    return true;
  }
  [[nodiscard]] static HalfHeights from(double) { return {}; }

 private:
  static constexpr Sample kSign = 0x8000;
  // The neighbouring half upward (direction 1) or downward (-1). Its magnitude, as an integer, is the half's
  // rank.
  [[nodiscard]] static Sample next(Sample half, int direction) {
    if ((half & ~kSign) == 0) return static_cast<Sample>(direction > 0 ? 1 : kSign | 1);
    const bool grows = ((half & kSign) == 0) == (direction > 0);
    return static_cast<Sample>(grows ? half + 1 : half - 1);
  }
};

// Codes 1 to 65535: height = offset + quantum * code. Code 0 is no data.
struct CodedHeights {
  using Sample = std::uint16_t;
  static constexpr Sample kNone = 0;
  static constexpr double kLargestCode = 65535.0;

  double offset = 0.0;
  double quantum = 1.0;

  // Ties to the even code, so that roundings of many means do not add up to a bias.
  template <class Height>
  [[nodiscard]] bool nearest(Height height, Sample& out) const {
    constexpr double kWhole = 0x1.8p52;  // adding it leaves no fraction bits
    return take((steps(height) + kWhole) - kWhole, out);
  }
  [[nodiscard]] bool below(float height, Sample& out) const {
    double code = std::floor(steps(height));
    if (value(code) > static_cast<double>(height)) code -= 1.0;  // the division was rounded up to a whole number
    return take(code, out);
  }
  [[nodiscard]] bool above(float height, Sample& out) const {
    double code = std::ceil(steps(height));
    if (value(code) < static_cast<double>(height)) code += 1.0;
    return take(code, out);
  }
  [[nodiscard]] double value(double code) const { return offset + quantum * code; }
  [[nodiscard]] CodedHeights from(double origin) const { return {.offset = offset - origin, .quantum = quantum}; }

 private:
  template <class Height>
  [[nodiscard]] double steps(Height height) const {
    return (static_cast<double>(height) - offset) / quantum;
  }
  [[nodiscard]] static bool take(double code, Sample& out) {
    const bool holds = code >= 1.0 && code <= kLargestCode;
    out = holds ? static_cast<Sample>(code) : kNone;
    return holds;
  }
};

}  // namespace vt::channels
