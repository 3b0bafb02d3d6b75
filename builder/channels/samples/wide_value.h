// Numbers that a float does not hold, as two planes: a linear one with the nearest float, and one of
// PlaneRule::kRemainder with what that float misses. Together they are exact to 48 bits, and so are means of
// them. Floats are enough for samples of 8 and 16 bits and for floats; of doubles and 32-bit integers they
// would lose up to half a unit in 2^24 (a millimetre of 10 km, 64 of 2^31) before anything is measured. Pure
// functions, any thread.
#pragma once

#include <cmath>
#include <limits>

#include "builder/source/sample_type.h"

namespace vt::channels {

// Samples of the type may be numbers that no float is.
[[nodiscard]] constexpr bool is_wide(SampleType type) {
  return type == SampleType::kFloat64 || type == SampleType::kInt32 || type == SampleType::kUint32;
}

// offset + scale * sample may be numbers that no float is to a 64th of what one sample of difference makes.
[[nodiscard]] constexpr bool is_wide(SampleType type, double scale, double offset) {
  if (is_wide(type)) return true;
  const double size = scale < 0.0 ? -scale : scale;
  const double distance = offset < 0.0 ? -offset : offset;
  if (type == SampleType::kFloat32) return distance > 0.0;  // which are already as fine as floats are
  const double most = type == SampleType::kUint8 || type == SampleType::kInt8 ? 255.0 : 65535.0;
  return distance + size * most > size * 0x1p17;
}

// What `nearest`, the float that the value was rounded to, misses of it. Both are finite.
[[nodiscard]] inline float remainder_of(double value, float nearest) { return static_cast<float>(value - static_cast<double>(nearest)); }

// A value as a plane and the plane of its remainder hold it.
inline void split_wide(double value, float& nearest, float& remainder) {
  nearest = static_cast<float>(value);
  remainder = remainder_of(value, nearest);
}

// The greatest float that is not above a value, and the least that is not below it; an infinity where there
// is none.
[[nodiscard]] inline float float_below(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}
[[nodiscard]] inline float float_above(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

}  // namespace vt::channels
