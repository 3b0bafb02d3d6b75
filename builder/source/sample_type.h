// The numeric types in which source rasters keep their samples. A shared word: readers produce them, channels
// decode them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

namespace vt {

enum class SampleType : std::uint8_t { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat32, kFloat64 };
inline constexpr std::array kSampleTypes{SampleType::kUint8,  SampleType::kInt8,  SampleType::kUint16,  SampleType::kInt16,
                                         SampleType::kUint32, SampleType::kInt32, SampleType::kFloat32, SampleType::kFloat64};

[[nodiscard]] constexpr std::size_t sample_bytes(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
    case SampleType::kInt8:
      return 1;
    case SampleType::kUint16:
    case SampleType::kInt16:
      return 2;
    case SampleType::kUint32:
    case SampleType::kInt32:
    case SampleType::kFloat32:
      return 4;
    case SampleType::kFloat64:
      return 8;
  }
  return 0;
}

[[nodiscard]] constexpr const char* sample_name(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return "uint8";
    case SampleType::kInt8:
      return "int8";
    case SampleType::kUint16:
      return "uint16";
    case SampleType::kInt16:
      return "int16";
    case SampleType::kUint32:
      return "uint32";
    case SampleType::kInt32:
      return "int32";
    case SampleType::kFloat32:
      return "float32";
    case SampleType::kFloat64:
      return "float64";
  }
  return "?";
}

[[nodiscard]] constexpr std::optional<SampleType> sample_type_from_name(std::string_view name) {
  for (const SampleType type : kSampleTypes)
    if (name == sample_name(type)) return type;
  return std::nullopt;
}

// The sample that means "all of it" where nothing else is said: the largest integer, or 1 for floats.
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

// Calls use(std::type_identity<T>()) with the C++ type that holds one sample, and returns what it returns:
//   visit_sample_type(type, [&]<class T>(std::type_identity<T>) { return decode<T>(samples); });
template <class Use>
decltype(auto) visit_sample_type(SampleType type, const Use& use) {
  switch (type) {
    case SampleType::kUint8:
      return use(std::type_identity<std::uint8_t>());
    case SampleType::kInt8:
      return use(std::type_identity<std::int8_t>());
    case SampleType::kUint16:
      return use(std::type_identity<std::uint16_t>());
    case SampleType::kInt16:
      return use(std::type_identity<std::int16_t>());
    case SampleType::kUint32:
      return use(std::type_identity<std::uint32_t>());
    case SampleType::kInt32:
      return use(std::type_identity<std::int32_t>());
    case SampleType::kFloat32:
      return use(std::type_identity<float>());
    case SampleType::kFloat64:
      break;
  }
  return use(std::type_identity<double>());
}

[[nodiscard]] constexpr bool is_floating_point(SampleType type) { return type == SampleType::kFloat32 || type == SampleType::kFloat64; }

}  // namespace vt
