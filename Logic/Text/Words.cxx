#include "Text/Words.h"

#include "Text/Unicode.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace innergs {
namespace {

bool isLower(char32_t c) {
  return c >= 'a' && c <= 'z';
}
bool isUpper(char32_t c) {
  return c >= 'A' && c <= 'Z';
}
bool isDigit(char32_t c) {
  return c >= '0' && c <= '9';
}
bool isApostrophe(char32_t c) {
  return c == '\'' || c == 0x2019 || c == '`';
}

} // namespace

std::vector<std::string> wordsOf(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  const auto end = [&] {
    if (!word.empty()) words.push_back(std::move(word));
    word.clear();
  };
  char32_t before = ' ';
  for (std::size_t at = 0; at < text.size();) {
    const char32_t c = nextCodePoint(text, at);
    if (isUpper(c)) {
      if (isLower(before) && word.size() > 1) end();
      word += static_cast<char>(c - 'A' + 'a');
    } else if (isLower(c) || isDigit(c)) {
      word += static_cast<char>(c);
    } else if (isApostrophe(c)) {
      if (word == "l" || word == "d") word.clear(); // the French article
    } else if (c >= 0x300 && c < 0x370) {
      // a combining accent, as written by macOS
    } else {
      const std::string letters = withoutAccent(c);
      if (letters.empty()) end();
      word += letters;
    }
    before = c;
  }
  end();
  return words;
}

std::string singular(const std::string& word) {
  const auto ends = [&](std::string_view with) {
    return word.size() > with.size() + 1 && word.ends_with(with);
  };
  if (ends("ies") && word.size() > 4) return word.substr(0, word.size() - 3) + "y";
  if (word.size() < 4 || !ends("s") || ends("ss") || ends("us") || ends("is") || ends("as")) return word;
  return word.substr(0, word.size() - 1);
}

int editDistance(std::string_view a, std::string_view b, int limit) {
  const int m = static_cast<int>(a.size()), n = static_cast<int>(b.size());
  if (std::abs(m - n) > limit) return limit + 1;
  std::vector<int> above(n + 1), before(n + 1), row(n + 1);
  std::iota(before.begin(), before.end(), 0);
  for (int i = 1; i <= m; ++i) {
    row[0] = i;
    int least = i;
    for (int j = 1; j <= n; ++j) {
      row[j] = std::min({before[j] + 1, row[j - 1] + 1, before[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], above[j - 2] + 1);
      least = std::min(least, row[j]);
    }
    if (least > limit) return limit + 1;
    std::swap(above, before);
    std::swap(before, row);
  }
  return std::min(before[n], limit + 1);
}

} // namespace innergs
