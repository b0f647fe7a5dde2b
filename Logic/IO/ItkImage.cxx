#include "IO/ItkImage.h"

#include <cstring>
#include <map>
#include <vector>

namespace innergs {
namespace {

using Pixel = itk::CommonEnums::IOPixel;
using Component = itk::CommonEnums::IOComponent;

void checkPixels(const itk::ImageIOBase& io, const std::string& what, bool sequence) {
  const auto refuse = [&](const std::string& sentence) {
    throw Error(ErrorCode::UnsupportedImage, what + sentence);
  };
  switch (io.GetPixelType()) {
  case Pixel::SCALAR:
    break;
  case Pixel::RGB:
  case Pixel::RGBA:
    refuse(" has colour (RGB) pixels; convert it to grey values first.");
    break;
  case Pixel::COMPLEX:
    refuse(" has complex pixels; export its magnitude first.");
    break;
  default:
    if (io.GetPixelType() != Pixel::VECTOR || !sequence)
      refuse(" has several values per voxel (vectors or tensors); extract one component first.");
  }
  if (io.GetPixelType() == Pixel::SCALAR && io.GetNumberOfComponents() != 1)
    refuse(" has several values per voxel (vectors or tensors); extract one component first.");
  if (io.GetComponentType() == Component::UNKNOWNCOMPONENTTYPE)
    refuse(" has a voxel type that cannot be read; convert it to a common integer or floating-point type.");
}

template <typename T>
void convert(const std::byte* source, std::size_t first, std::size_t stride, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    T value;
    std::memcpy(&value, source + (first + i * stride) * sizeof(T), sizeof(T));
    out[i] = static_cast<float>(value);
  }
}

} // namespace

ItkHeader describe(const itk::ImageIOBase& io, const std::string& what, bool sequence) {
  checkPixels(io, what, sequence);
  const unsigned dimensions = io.GetNumberOfDimensions();
  if (dimensions < 3)
    throw Error(ErrorCode::UnsupportedImage,
                what + " is a single slice (2D); a volume with slices is needed.");
  ItkHeader header;
  for (unsigned axis = 0; axis < 3; ++axis) {
    header.geometry.size[axis] = static_cast<std::int64_t>(io.GetDimensions(axis));
    header.geometry.spacing[axis] = io.GetSpacing(axis);
    header.geometry.origin[axis] = io.GetOrigin(axis);
    const std::vector<double> direction = io.GetDirection(axis);
    for (unsigned row = 0; row < 3; ++row)
      header.geometry.direction[row][axis] = row < direction.size() ? direction[row] : 0;
  }
  if (io.GetNumberOfComponents() > 1) {
    header.frames = io.GetNumberOfComponents();
    header.interleaved = true;
  }
  for (unsigned axis = 3; axis < dimensions; ++axis) {
    const auto length = static_cast<std::int64_t>(io.GetDimensions(axis));
    if (length < 1 || header.frames > (std::int64_t{1} << 40) / length)
      throw Error(ErrorCode::FileFormat, what + " has an impossible number of frames; it is damaged.");
    header.frames *= length;
  }
  return header;
}

void convertVoxels(Component type, const std::byte* source, std::size_t first, std::size_t stride,
                   std::span<float> out) {
  using Convert = void (*)(const std::byte*, std::size_t, std::size_t, std::span<float>);
  static const std::map<Component, Convert> converters{{Component::UCHAR, convert<unsigned char>},
                                                       {Component::CHAR, convert<signed char>},
                                                       {Component::USHORT, convert<unsigned short>},
                                                       {Component::SHORT, convert<short>},
                                                       {Component::UINT, convert<unsigned int>},
                                                       {Component::INT, convert<int>},
                                                       {Component::ULONG, convert<unsigned long>},
                                                       {Component::LONG, convert<long>},
                                                       {Component::ULONGLONG, convert<unsigned long long>},
                                                       {Component::LONGLONG, convert<long long>},
                                                       {Component::FLOAT, convert<float>},
                                                       {Component::DOUBLE, convert<double>}};
  const auto found = converters.find(type);
  if (found == converters.end())
    throw Error(ErrorCode::UnsupportedImage, "The image has a voxel type that cannot be read.");
  found->second(source, first, stride, out);
}

} // namespace innergs
