// SHA-256 (FIPS 180-4) for comparing whole rasters with their recorded hashes. Test code: short, not fast.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vt::test {

class Sha256 {
 public:
  void add(std::span<const std::byte> bytes) {
    length_ += bytes.size();
    while (!bytes.empty()) {
      const std::size_t take = std::min(bytes.size(), block_.size() - held_);
      std::copy_n(bytes.begin(), take, block_.begin() + static_cast<std::ptrdiff_t>(held_));
      held_ += take;
      bytes = bytes.subspan(take);
      if (held_ == block_.size()) {
        mix();
        held_ = 0;
      }
    }
  }

  std::string hex() {
    const std::uint64_t bits = length_ * 8;
    const std::byte one{0x80};
    add({&one, 1});
    const std::byte zero{0};
    while (held_ != 56) add({&zero, 1});
    std::array<std::byte, 8> tail{};
    for (int i = 0; i < 8; ++i) tail[static_cast<std::size_t>(i)] = static_cast<std::byte>(bits >> (56 - 8 * i));
    add(tail);
    std::string text;
    for (const std::uint32_t word : state_) {
      for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
    }
    return text;
  }

 private:
  void mix();

  std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> block_{};
  std::size_t held_ = 0;
  std::uint64_t length_ = 0;
};

}  // namespace vt::test
