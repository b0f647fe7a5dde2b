#include "Markdown.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace innergs::bench {
namespace {

std::size_t width(const std::string& text) { // code points of UTF-8
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

std::string printed(const char* pattern, double value, int digits) {
  if (!std::isfinite(value)) return "–";
  char text[64];
  std::snprintf(text, sizeof(text), pattern, digits, value);
  return text;
}

} // namespace

std::string MarkdownTable::text() const {
  std::vector<std::size_t> widths(rows_[0].size(), 3);
  for (const auto& row : rows_)
    for (std::size_t c = 0; c < widths.size(); ++c)
      if (c < row.size()) widths[c] = std::max(widths[c], width(row[c]));
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string cell = c < rows_[r].size() ? rows_[r][c] : "";
      text += "| " + cell + std::string(widths[c] - width(cell) + 1, ' ');
    }
    text += "|\n";
    if (r > 0) continue;
    for (std::size_t w : widths)
      text += "|" + std::string(w + 2, '-');
    text += "|\n";
  }
  return text;
}

std::string fixed(double value, int digits) {
  return printed("%.*f", value, digits);
}
std::string withSign(double value, int digits) {
  return printed("%+.*f", value, digits);
}

std::string verdict(bool met, double distance, int digits, const std::string& unit) {
  return met ? "yes" : "no, by " + fixed(std::abs(distance), digits) + " " + unit;
}

} // namespace innergs::bench
