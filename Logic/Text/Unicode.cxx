#include "Text/Unicode.h"

#include <utility>

namespace innergs {

char32_t nextCodePoint(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
  const unsigned char first = byte(at++);
  if (first < 0x80) return first;
  const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : first >= 0xc0 ? 1 : 0;
  char32_t code = first & (0x3f >> more);
  for (int n = 0; n < more; ++n) {
    if (at >= text.size() || (byte(at) & 0xc0) != 0x80) return 0xfffd;
    code = code << 6 | (byte(at++) & 0x3f);
  }
  return more == 0 ? 0xfffd : code;
}

std::string withoutAccent(char32_t c) {
  // U+00C0 to U+017F; '-' if the code point is not a letter or becomes two letters.
  static constexpr std::string_view latin1 = "aaaaaa-ceeeeiiiidnooooo-ouuuuy--"
                                             "aaaaaa-ceeeeiiiidnooooo-ouuuuy-y";
  static constexpr std::string_view extended =
      "aaaaaaccccccccddddeeeeeeeeeegggggggghhhhiiiiiiiiii--jjkkkllllllllllnnnnnnnnnoooooo--rrrrrrssssssss"
      "ttttttuuuuuuuuuuuuwwyyyzzzzzzs";
  // U+01CD to U+0233 (Pinyin, Romanian) and U+1E00 to U+1EFF (Vietnamese)
  static constexpr std::string_view latinB =
      "aaiioouuuuuuuuuu-aaaa----ggkkoooo--j---gg--nnaa----aaaaeeeeiiiioooorrrruuuusstt--hh------aaeeooo"
      "oooooyy";
  static constexpr std::string_view additional =
      "aabbbbbbccddddddddddeeeeeeeeeeffgghhhhhhhhhhiiiikkkkkkllllllllmmmmmmnnnnnnnnoooooooopppprrrrrrrr"
      "ssssssssssttttttttuuuuuuuuuuvvvvwwwwwwwwwwxxxxyyzzzzzzhtwy------aaaaaaaaaaaaaaaaaaaaaaaaeeeeeeee"
      "eeeeeeeeiiiioooooooooooooooooooooooouuuuuuuuuuuuuuyyyyyyyy------";
  if (c >= 0xc0 && c < 0x100) {
    const char letter = latin1[c - 0xc0];
    if (letter != '-') return {letter};
    return c == 0xc6 || c == 0xe6 ? "ae" : c == 0xdf ? "ss" : "";
  }
  if (c >= 0x100 && c < 0x100 + extended.size()) {
    const char letter = extended[c - 0x100];
    if (letter != '-') return {letter};
    return c == 0x152 || c == 0x153 ? "oe" : c == 0x132 || c == 0x133 ? "ij" : "";
  }
  if (c == 0x1e9e) return "ss";
  for (const auto& [first, letters] : {std::pair{char32_t{0x1cd}, latinB}, {char32_t{0x1e00}, additional}})
    if (c >= first && c < first + letters.size() && letters[c - first] != '-') return {letters[c - first]};
  return "";
}

void appendUtf8(std::string& text, char32_t c) {
  const auto byte = [&](char32_t value) { text += static_cast<char>(static_cast<unsigned char>(value)); };
  if (c < 0x80) {
    byte(c);
  } else if (c < 0x800) {
    byte(0xc0 | c >> 6);
    byte(0x80 | (c & 0x3f));
  } else if (c < 0x10000) {
    byte(0xe0 | c >> 12);
    byte(0x80 | (c >> 6 & 0x3f));
    byte(0x80 | (c & 0x3f));
  } else {
    byte(0xf0 | c >> 18);
    byte(0x80 | (c >> 12 & 0x3f));
    byte(0x80 | (c >> 6 & 0x3f));
    byte(0x80 | (c & 0x3f));
  }
}

} // namespace innergs
