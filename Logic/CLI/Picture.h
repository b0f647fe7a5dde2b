#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace innergs::cli {

using Colour = std::array<std::uint8_t, 3>;

/// An 8-bit RGB image, row by row from the top left.
struct Picture {
  Picture(int width, int height, Colour background = {0, 0, 0});
  int width, height;
  std::vector<std::uint8_t> rgb;

  void set(int x, int y, Colour colour); // ignored outside
  /// Draws ASCII text, 8×13 pixels per letter times `scale`, with its top left corner at (x, y).
  void text(int x, int y, const std::string& line, Colour colour = {255, 255, 255}, int scale = 1);
  static int textWidth(const std::string& line, int scale = 1);
};

/// Writes an 8-bit PNG: 1 channel (grey) or 3 (RGB). Throws Error(Io).
void writePng(const std::filesystem::path& path, int width, int height, int channels,
              std::span<const std::uint8_t> bytes);

} // namespace innergs::cli
