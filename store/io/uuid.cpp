#include "store/io/uuid.h"

#include <random>

#include "store/io/bytes.h"
#include "store/io/hex.h"

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
  // The first eight bytes, of which four bits are the UUID's version.
  const Uuid random = random_uuid();
  std::string digits;
  for (std::size_t i = 0; i < kRandomDigits / 2; ++i) digits += hex(std::to_integer<unsigned>(random[i]), 2);
  return digits;
}

}  // namespace vt::store
