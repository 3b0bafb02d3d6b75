// Content known again by its hash: what an update compares instead of clocks. XXH3 of xxHash 0.8, seed 0.
// Threads: free functions any thread; a ContentHasher belongs to one.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace vt::store {

// 128 bits, in the order of XXH128_canonicalFromHash. Enough that two different contents never meet by
// accident; not a defence against somebody who looks for a collision.
struct ContentHash {
  std::array<std::byte, 16> bytes = {};
  auto operator<=>(const ContentHash&) const = default;
};

// Hashes a sequence of pieces. Where the pieces are cut does not matter.
class ContentHasher {
 public:
  ContentHasher();
  ContentHasher(ContentHasher&&) noexcept;
  ContentHasher& operator=(ContentHasher&&) noexcept;
  ~ContentHasher();

  void add(std::span<const std::byte> bytes);
  [[nodiscard]] ContentHash digest() const;  // of all that was added so far
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The 64-bit hash of some bytes as 16 hex digits.
[[nodiscard]] std::string content_hash(std::span<const std::byte> bytes);

}  // namespace vt::store
