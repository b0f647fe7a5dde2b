#include "Core/NumberText.h"

#include <charconv>

namespace innergs {

std::string numberText(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value, std::chars_format::general, 6).ptr;
  return {text, end};
}

std::string countText(std::int64_t count) {
  std::string text = std::to_string(count);
  const std::size_t digits = text.size(), first = count < 0 ? 1 : 0;
  for (std::size_t at = digits; at > first + 3; at -= 3)
    text.insert(at - 3, 1, ',');
  return text;
}

} // namespace innergs
