#include "IO/PlyHeader.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"

#include <cstring>
#include <fstream>
#include <locale>
#include <optional>
#include <sstream>

namespace innergs {
namespace {

constexpr int longestLine = 4096, mostLines = 4096;

std::optional<PlyHeader::Property> propertyType(const std::string& type) {
  static const std::map<std::string, PlyHeader::Property> table{
      {"char", {0, 1, 'i'}},  {"int8", {0, 1, 'i'}},    {"uchar", {0, 1, 'u'}},  {"uint8", {0, 1, 'u'}},
      {"short", {0, 2, 'i'}}, {"int16", {0, 2, 'i'}},   {"ushort", {0, 2, 'u'}}, {"uint16", {0, 2, 'u'}},
      {"int", {0, 4, 'i'}},   {"int32", {0, 4, 'i'}},   {"uint", {0, 4, 'u'}},   {"uint32", {0, 4, 'u'}},
      {"float", {0, 4, 'f'}}, {"float32", {0, 4, 'f'}}, {"double", {0, 8, 'f'}}, {"float64", {0, 8, 'f'}}};
  const auto found = table.find(type);
  if (found == table.end()) return std::nullopt;
  return found->second;
}

bool readLine(std::ifstream& in, std::string& line) {
  line.clear();
  char c = 0;
  while (in.get(c) && c != '\n') {
    if (line.size() >= longestLine) return false;
    line += c;
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return static_cast<bool>(in);
}

template <typename T>
double valueAs(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

} // namespace

PlyHeader readPlyHeader(const std::filesystem::path& path) {
  const std::uint64_t fileBytes = checkInputFile(path);
  const auto fail = [&](const std::string& why) { throw Error(ErrorCode::FileFormat, quoted(path) + why); };
  const auto damaged = [&](const std::string& why) {
    fail(" is not a PLY file of Gaussians or is damaged (" + why + "); export it again.");
  };
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!readLine(in, line) || line != "ply") damaged("it does not start with 'ply'");

  PlyHeader header;
  std::string element;
  bool hasFormat = false, hasVertex = false, ended = false;
  for (int count = 0; count < mostLines && !ended && readLine(in, line); ++count) {
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    std::string word, type, name;
    words >> word;
    if (word == "format") {
      words >> type;
      if (type != "binary_little_endian")
        fail(" is an ASCII or big-endian PLY file; export it as binary little-endian.");
      hasFormat = true;
    } else if (word == "comment") {
      std::string key, value;
      if (words >> word >> key && word == "innergs") {
        std::getline(words >> std::ws, value);
        header.comments[key] = value;
      }
    } else if (word == "element") {
      words >> element;
      if (!hasVertex && element != "vertex") damaged("its first element is not 'vertex'");
      if (element == "vertex") {
        if (hasVertex || !(words >> header.vertices) || header.vertices < 0)
          damaged("its number of vertices is wrong");
        hasVertex = true;
      }
    } else if (word == "property" && element == "vertex") {
      words >> type >> name;
      std::optional<PlyHeader::Property> property = propertyType(type);
      if (!property) damaged("the vertex property type '" + type + "' is not supported");
      property->offset = header.vertexBytes;
      header.vertexBytes += static_cast<std::size_t>(property->bytes);
      if (!header.properties.emplace(name, *property).second) damaged("a vertex property appears twice");
    } else if (word == "end_header") {
      ended = true;
    }
  }
  if (!ended || !hasFormat || !hasVertex || header.vertexBytes == 0) damaged("its header is cut off");
  header.dataStart = static_cast<std::uint64_t>(in.tellg());
  if (header.dataStart > fileBytes ||
      static_cast<std::uint64_t>(header.vertices) > (fileBytes - header.dataStart) / header.vertexBytes)
    damaged("it is shorter than its header says");
  return header;
}

double plyValue(const PlyHeader::Property& property, const char* vertex) {
  const char* at = vertex + property.offset;
  if (property.kind == 'f') return property.bytes == 4 ? valueAs<float>(at) : valueAs<double>(at);
  if (property.kind == 'i')
    return property.bytes == 1   ? valueAs<std::int8_t>(at)
           : property.bytes == 2 ? valueAs<std::int16_t>(at)
                                 : valueAs<std::int32_t>(at);
  return property.bytes == 1   ? valueAs<std::uint8_t>(at)
         : property.bytes == 2 ? valueAs<std::uint16_t>(at)
                               : valueAs<std::uint32_t>(at);
}

} // namespace innergs
