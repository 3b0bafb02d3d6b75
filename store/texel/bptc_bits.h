// The 128 bits of a BPTC block (BC6H or BC7), read and written in order from bit 0 of byte 0. Both formats
// are sequences of such fields.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

class BptcBitReader {
 public:
  explicit BptcBitReader(std::span<const std::byte, 16> block) {
    for (std::size_t i = 8; i-- > 0;) {
      low_ = low_ << 8U | std::to_integer<std::uint64_t>(block[i]);
      high_ = high_ << 8U | std::to_integer<std::uint64_t>(block[8 + i]);
    }
  }

  // The next `count` bits, 0 to 31, the first one lowest.
  std::uint32_t take(unsigned count) {
    assert(count < 32);
    const auto value = static_cast<std::uint32_t>(low_ & ((std::uint64_t{1} << count) - 1));
    if (count != 0) {
      low_ = low_ >> count | high_ << (64U - count);
      high_ >>= count;
    }
    return value;
  }

 private:
  std::uint64_t low_ = 0;
  std::uint64_t high_ = 0;
};

class BptcBitWriter {
 public:
  // Appends the lowest `count` bits of `value`; the others must be 0.
  void put(std::uint64_t value, unsigned count) {
    assert(count <= 64 && (count == 64 || value >> count == 0) && size_ + count <= 128);
    if (size_ < 64) {
      low_ |= value << size_;
      if (size_ + count > 64) high_ |= value >> (64U - size_);
    } else if (size_ < 128) {
      high_ |= value << (size_ - 64U);
    }
    size_ += count;
  }

  [[nodiscard]] unsigned size() const { return size_; }

  void store(std::span<std::byte, 16> block) const {
    for (std::size_t i = 0; i < 8; ++i) {
      block[i] = static_cast<std::byte>(low_ >> (8 * i));
      block[8 + i] = static_cast<std::byte>(high_ >> (8 * i));
    }
  }

 private:
  std::uint64_t low_ = 0;
  std::uint64_t high_ = 0;
  unsigned size_ = 0;
};

}  // namespace vt::store
