// Text that came from outside: names, metadata and paths may hold any bytes. What is UTF-8, what may be a
// name, and how a text is shown so that it cannot steer a terminal. And how numbers are shown. Pure
// functions, any thread.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace vt::store {

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
[[nodiscard]] bool is_utf8(std::string_view text);

// UTF-8 without a character that does something instead of being seen: C0 and C1 controls and DEL, which
// terminals obey, line and paragraph separators, and the embeddings, overrides and isolates that make what
// follows read in another order (U+2028 to U+202E, U+2066 to U+2069).
[[nodiscard]] bool is_plain_text(std::string_view text);

// The text with each of those characters as \u and four hexadecimal digits, and each byte that is not UTF-8
// as \x and two. In JSON strings this is the same text still.
[[nodiscard]] std::string printable(std::string_view text);
// The same for text that is laid out already: line feeds and tabs stay.
[[nodiscard]] std::string printable_lines(std::string_view text);

// A number in a message.
[[nodiscard]] inline std::string number(std::integral auto value) { return std::to_string(value); }

}  // namespace vt::store
