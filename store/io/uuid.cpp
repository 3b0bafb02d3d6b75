#include "store/io/uuid.h"

#include <random>
#include <string_view>

#include "store/io/bytes.h"

namespace vt::store {

Uuid random_uuid() {
  std::random_device device;
  Uuid uuid;
  for (std::size_t i = 0; i < uuid.size(); i += 4) put<std::uint32_t>(uuid, i, device());
  uuid[6] = (uuid[6] & std::byte{0x0F}) | std::byte{0x40};
  uuid[8] = (uuid[8] & std::byte{0x3F}) | std::byte{0x80};
  return uuid;
}

std::string random_digits() {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string digits;
  const Uuid random = random_uuid();
  // The first eight bytes, of which four bits are the UUID's version.
  for (std::size_t i = 0; i < kRandomDigits / 2; ++i) {
    const auto byte = std::to_integer<unsigned>(random[i]);
    digits += {kHex[byte / 16], kHex[byte % 16]};
  }
  return digits;
}

}  // namespace vt::store
