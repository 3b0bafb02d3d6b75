#include "store/format/text.h"

#include <gtest/gtest.h>

#include <string>

namespace vt::store {
namespace {

// The UTF-8 of any code up to 0x1FFFFF, right or not, by the plain pattern of bits.
std::string bytes_of(std::uint32_t code) {
  const auto tail = [&](unsigned shift) { return static_cast<char>(0x80U | (code >> shift & 0x3FU)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0U | code >> 6U), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xE0U | code >> 12U), tail(6), tail(0)};
  return {static_cast<char>(0xF0U | code >> 18U), tail(12), tail(6), tail(0)};
}

// Told one by one, from the Unicode tables: Cc, Zl, Zp, and of Cf those that embed, override, isolate and end
// such.
bool is_dangerous(std::uint32_t code) {
  switch (code) {
    case 0x7F:
    case 0x2028:
    case 0x2029:
    case 0x202A:
    case 0x202B:
    case 0x202C:
    case 0x202D:
    case 0x202E:
    case 0x2066:
    case 0x2067:
    case 0x2068:
    case 0x2069:
      return true;
    default:
      return code < 0x20 || (code >= 0x80 && code <= 0x9F);
  }
}

TEST(Text, EveryCharacterIsPlainOrSpelledOut) {
  int spelled_out = 0;
  for (std::uint32_t code = 0; code <= 0x10FFFF; ++code) {
    const std::string bytes = bytes_of(code);
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    ASSERT_EQ(is_utf8(bytes), !is_surrogate) << code;
    ASSERT_EQ(is_plain_text(bytes), !is_surrogate && !is_dangerous(code)) << code;
    const std::string shown = printable("a" + bytes + "z");
    ASSERT_TRUE(is_plain_text(shown)) << code;
    if (is_plain_text(bytes)) {
      ASSERT_EQ(shown, "a" + bytes + "z") << code;
    } else {
      ++spelled_out;
    }
  }
  EXPECT_EQ(spelled_out, 0x20 + 0x21 + 7 + 4 + 0x800);  // C0, DEL with C1, two ranges, surrogates
  EXPECT_EQ(printable("\x1b]0;owned\a"), "\\u001b]0;owned\\u0007");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u009b31m");
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "fdp.exe"),
            "\\u202efdp.exe");
  EXPECT_EQ(printable("one\ntwo\t\r"), "one\\u000atwo\\u0009\\u000d");
  EXPECT_EQ(printable_lines("one\ntwo\t\r\x1b"), "one\ntwo\t\\u000d\\u001b");
}

TEST(Text, BytesThatAreNoUtf8AreSpelledOutOneByOne) {
  EXPECT_EQ(printable("a\xff\xfe"
                      "b"),
            "a\\xff\\xfeb");
  EXPECT_EQ(printable("\xc3"), "\\xc3");                             // cut off
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                    // overlong
  EXPECT_EQ(printable("\xe0\x80\x9b"), "\\xe0\\x80\\x9b");           // an overlong C1
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // above U+10FFFF
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b"
            "31m");  // C1 as one byte
  // Whatever the bytes, what is shown is plain.
  for (int first = 0; first < 256; ++first)
    for (int second = 0; second < 256; ++second) {
      const std::string bytes{static_cast<char>(first), static_cast<char>(second), 'x'};
      ASSERT_TRUE(is_plain_text(printable(bytes))) << first << ' ' << second;
      ASSERT_EQ(printable(bytes) == bytes, is_plain_text(bytes)) << first << ' ' << second;
    }
}

}  // namespace
}  // namespace vt::store
