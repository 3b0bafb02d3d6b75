// One sample of any numeric type as a double. For the channels' general paths; the common types have row loops of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "builder/source/sample_type.h"

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

}  // namespace vt::channels
