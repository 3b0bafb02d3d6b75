// Little-endian integers and floats in byte buffers: the only way in which numbers cross between memory and
// file. Pure functions, any thread.
#pragma once

#include <bit>
#include <cassert>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace vt::store {

namespace detail {
template <std::unsigned_integral T>
[[nodiscard]] constexpr T little_endian(T value) {
  if constexpr (std::endian::native == std::endian::little || sizeof(T) == 1) return value;
  T swapped = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) swapped = static_cast<T>((swapped << 8) | ((value >> (8 * i)) & 0xFF));
  return swapped;
}
}  // namespace detail

// The caller has checked that the number lies inside `bytes`.
template <std::unsigned_integral T>
[[nodiscard]] inline T get(std::span<const std::byte> bytes, std::size_t at) {
  assert(at <= bytes.size() && sizeof(T) <= bytes.size() - at);
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return detail::little_endian(value);
}

template <std::unsigned_integral T>
inline void put(std::span<std::byte> bytes, std::size_t at, std::type_identity_t<T> value) {
  assert(at <= bytes.size() && sizeof(T) <= bytes.size() - at);
  value = detail::little_endian(value);
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

[[nodiscard]] inline double get_f64(std::span<const std::byte> bytes, std::size_t at) {
  return std::bit_cast<double>(get<std::uint64_t>(bytes, at));
}
inline void put_f64(std::span<std::byte> bytes, std::size_t at, double value) {
  put<std::uint64_t>(bytes, at, std::bit_cast<std::uint64_t>(value));
}
[[nodiscard]] inline std::int64_t get_i64(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::int64_t>(get<std::uint64_t>(bytes, at));
}
inline void put_i64(std::span<std::byte> bytes, std::size_t at, std::int64_t value) {
  put<std::uint64_t>(bytes, at, static_cast<std::uint64_t>(value));
}
[[nodiscard]] inline std::string_view get_text(std::span<const std::byte> bytes, std::size_t at, std::size_t length) {
  assert(at <= bytes.size() && length <= bytes.size() - at);
  return {reinterpret_cast<const char*>(bytes.data()) + at, length};
}
inline void put_text(std::span<std::byte> bytes, std::size_t at, std::string_view text) {
  assert(at <= bytes.size() && text.size() <= bytes.size() - at);
  if (!text.empty()) std::memcpy(bytes.data() + at, text.data(), text.size());
}
[[nodiscard]] inline bool all_zero(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes)
    if (b != std::byte{0}) return false;
  return true;
}

}  // namespace vt::store
