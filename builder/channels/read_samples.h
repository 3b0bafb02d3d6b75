// One sample of any numeric type as a double. For the channels' general paths; the common types have row loops of their own.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "store/sample_type.h"

namespace vt::channels {

template <class T>
[[nodiscard]] inline double read_as(const std::byte* sample) {
  T value;
  std::memcpy(&value, sample, sizeof value);
  return static_cast<double>(value);
}

[[nodiscard]] inline double read_sample(SampleType type, const std::byte* sample) {
  switch (type) {
    case SampleType::kUint8:
      return read_as<std::uint8_t>(sample);
    case SampleType::kInt8:
      return read_as<std::int8_t>(sample);
    case SampleType::kUint16:
      return read_as<std::uint16_t>(sample);
    case SampleType::kInt16:
      return read_as<std::int16_t>(sample);
    case SampleType::kUint32:
      return read_as<std::uint32_t>(sample);
    case SampleType::kInt32:
      return read_as<std::int32_t>(sample);
    case SampleType::kFloat32:
      return read_as<float>(sample);
    case SampleType::kFloat64:
      return read_as<double>(sample);
  }
  return 0.0;
}

// The value that means "all of it": the largest integer, or 1 for floats.
[[nodiscard]] constexpr double full_scale(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return 255.0;
    case SampleType::kInt8:
      return 127.0;
    case SampleType::kUint16:
      return 65535.0;
    case SampleType::kInt16:
      return 32767.0;
    case SampleType::kUint32:
      return 4294967295.0;
    case SampleType::kInt32:
      return 2147483647.0;
    case SampleType::kFloat32:
    case SampleType::kFloat64:
      return 1.0;
  }
  return 1.0;
}

// Files write nodata as decimal text; a float sample equals it when both round to the same float.
[[nodiscard]] inline bool equals_nodata(SampleType type, double value, double nodata) {
  if (type == SampleType::kFloat32) return static_cast<float>(value) == static_cast<float>(nodata);
  return value == nodata;
}

// The sample of a row of `type`, whose C++ type is T, that equals_nodata(); none when no finite sample does.
template <class T>
[[nodiscard]] inline std::optional<T> nodata_sample(SampleType type, std::optional<double> nodata) {
  if (!nodata || !std::isfinite(*nodata)) return std::nullopt;
  constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
  constexpr auto kHighest = static_cast<double>(std::numeric_limits<T>::max());
  const T nearest = static_cast<T>(std::clamp(*nodata, kLowest, kHighest));
  return equals_nodata(type, static_cast<double>(nearest), *nodata) ? std::optional<T>(nearest) : std::nullopt;
}

}  // namespace vt::channels
