#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace innergs {

/// A path as UTF-8, the encoding used by ITK, error messages and JSON.
inline std::string utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

/// The path that UTF-8 text names, on any system.
inline std::filesystem::path pathOf(std::string_view utf8) {
  return std::u8string(utf8.begin(), utf8.end());
}

} // namespace innergs
