// Names that nobody guesses and nothing else has: what stores carry for life, and what files are called for a
// while.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace vt::store {

using Uuid = std::array<std::byte, 16>;
// RFC 4122, version 4: random. Any thread.
[[nodiscard]] Uuid random_uuid();

// Hexadecimal, for the name of a file: kRandomDigits of them. Any thread.
inline constexpr std::size_t kRandomDigits = 16;
[[nodiscard]] std::string random_digits();

}  // namespace vt::store
