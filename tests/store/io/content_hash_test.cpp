#include "store/io/content_hash.h"

#include <gtest/gtest.h>

#include <vector>

namespace vt::store {
namespace {

std::string hex(const ContentHash& hash) {
  std::string text;
  for (const std::byte b : hash.bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[std::to_integer<unsigned>(b) >> 4];
    text += kDigits[std::to_integer<unsigned>(b) & 15];
  }
  return text;
}

// xxHash's own test vector: XXH3_128bits of nothing, seed 0.
TEST(ContentHasher, HashesNothingAsXxHashDoes) { EXPECT_EQ(hex(ContentHasher().digest()), "99aa06d3014798d86001c324468d497f"); }

TEST(ContentHasher, DoesNotSeeWhereThePiecesAreCut) {
  std::vector<std::byte> bytes(5000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 7 + i / 256);
  ContentHasher whole;
  whole.add(bytes);
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, std::size_t{239}, std::size_t{256}, std::size_t{4999}, bytes.size()}) {
    ContentHasher pieces;
    pieces.add(std::span(bytes).first(cut));
    pieces.add(std::span(bytes).subspan(cut));
    EXPECT_EQ(pieces.digest(), whole.digest()) << cut;
  }
}

TEST(ContentHasher, StartsAgainAfterReset) {
  ContentHasher hasher;
  hasher.add(std::as_bytes(std::span("something")));
  EXPECT_NE(hasher.digest(), ContentHasher().digest());
  hasher.reset();
  EXPECT_EQ(hasher.digest(), ContentHasher().digest());
}

}  // namespace
}  // namespace vt::store
