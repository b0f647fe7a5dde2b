#include "CLI/Picture.h"

#include "CLI/Font8x13.h"
#include "Core/Base/Error.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"

#include <itkPNGImageIO.h>

namespace innergs::cli {

Picture::Picture(int w, int h, Colour background)
    : width(w), height(h), rgb(3 * static_cast<std::size_t>(w) * h) {
  for (std::size_t n = 0; n < rgb.size(); ++n)
    rgb[n] = background[n % 3];
}

void Picture::set(int x, int y, Colour colour) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  for (int c = 0; c < 3; ++c)
    rgb[3 * (static_cast<std::size_t>(y) * width + x) + c] = colour[c];
}

void Picture::text(int x, int y, const std::string& line, Colour colour, int scale) {
  for (const unsigned char letter : line) {
    const auto& glyph = font8x13[letter >= 32 && letter < 127 ? letter - 32 : '?' - 32];
    for (int row = 0; row < 13 * scale; ++row)
      for (int column = 0; column < 8 * scale; ++column)
        if (glyph[row / scale] >> (7 - column / scale) & 1) set(x + column, y + row, colour);
    x += 8 * scale;
  }
}

int Picture::textWidth(const std::string& line, int scale) {
  return 8 * scale * static_cast<int>(line.size());
}

void writePng(const std::filesystem::path& path, int width, int height, int channels,
              std::span<const std::uint8_t> bytes) {
  writeAtomically(path, [&](const std::filesystem::path& file) {
    try {
      auto io = itk::PNGImageIO::New();
      io->SetNumberOfDimensions(2);
      io->SetDimensions(0, width);
      io->SetDimensions(1, height);
      io->SetComponentType(itk::IOComponentEnum::UCHAR);
      io->SetPixelType(channels == 1 ? itk::IOPixelEnum::SCALAR : itk::IOPixelEnum::RGB);
      io->SetNumberOfComponents(channels);
      io->SetFileName(utf8(file));
      io->UseCompressionOn();
      io->Write(bytes.data());
    } catch (const itk::ExceptionObject& error) {
      throw Error(ErrorCode::Io, "Cannot write the picture " + quoted(path) + ": " + error.GetDescription());
    }
  });
}

} // namespace innergs::cli
