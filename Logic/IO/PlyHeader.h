#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace innergs {

/// The header of a binary little-endian PLY file whose first element is `vertex`, checked against the file's
/// length.
struct PlyHeader {
  struct Property {
    std::size_t offset = 0; // bytes from the start of a vertex
    int bytes = 0;
    char kind = 'f'; // f: floating point, i: signed, u: unsigned
  };
  std::int64_t vertices = 0;
  std::size_t vertexBytes = 0;
  std::uint64_t dataStart = 0;
  std::map<std::string, Property> properties;
  std::map<std::string, std::string> comments; // "comment innergs KEY VALUE"
};

/// Throws Error(FileNotFound | FileFormat).
PlyHeader readPlyHeader(const std::filesystem::path& path);

/// The value of a property; `vertex`: start of the vertex in memory.
double plyValue(const PlyHeader::Property& property, const char* vertex);

} // namespace innergs
