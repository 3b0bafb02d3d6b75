// One sample of any numeric type as a double. For the channels' general paths; the common types have row
// loops of their own.
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
  return visit_sample_type(type, [&]<class T>(std::type_identity<T>) { return read_as<T>(sample); });
}

}  // namespace vt::channels
