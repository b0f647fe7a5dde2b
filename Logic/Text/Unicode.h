#pragma once
#include <string>
#include <string_view>

namespace innergs {

/// Returns the code point at `at` of a text in UTF-8 and advances `at`; U+FFFD for invalid UTF-8.
char32_t nextCodePoint(std::string_view text, std::size_t& at);
void appendUtf8(std::string& text, char32_t c);

/// An accented Latin letter in lower-case ASCII, "ae" for the likes of æ; "" if it is none.
std::string withoutAccent(char32_t c);

} // namespace innergs
