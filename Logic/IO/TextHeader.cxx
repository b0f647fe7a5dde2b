#include "IO/TextHeader.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/FilePath.h"
#include "IO/Inflate.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <vector>

namespace innergs {
namespace {

using TextFields = std::map<std::string, std::string>;
struct TextHeader {
  TextFields fields;
  std::size_t longestField = 0; // characters of a line that is neither a comment nor NRRD's key:=value
  std::uint64_t end = 0;        // bytes from the start of the file
};

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Reads "key<separator>value" lines up to the empty line or the field that ends the header.
TextHeader readHeader(const std::filesystem::path& path, char separator, const std::string& last) {
  TextHeader header;
  std::ifstream in(path, std::ios::binary);
  constexpr std::size_t longestHeader = 16 << 20; // tracked ultrasound has a few lines per frame
  for (std::string line; header.end < longestHeader && std::getline(in, line);) {
    header.end += line.size() + 1;
    if (trimmed(line).empty()) break;
    if (!line.starts_with('#') && line.find(":=") == std::string::npos)
      header.longestField = std::max(header.longestField, line.size());
    const std::size_t at = line.find(separator);
    if (at == std::string::npos) continue;
    const std::string key = trimmed(line.substr(0, at));
    header.fields[key] = trimmed(line.substr(at + 1));
    if (key == last) break;
  }
  return header;
}

/// Numbers separated by blanks, brackets and commas; skips words such as "none".
std::vector<double> numbers(const std::string& text) {
  std::vector<double> values;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t start = text.find_first_not_of(" \t(),", at);
    if (start == std::string::npos) break;
    at = std::min(text.find_first_of(" \t(),", start), text.size());
    const std::string word = text.substr(start, at - start);
    if (const auto value = leadingNumber(word)) values.push_back(*value);
  }
  return values;
}

/// Words separated by blanks; a quoted text is one word, without its quotation marks.
std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> all;
  for (std::size_t at = text.find_first_not_of(" \t"); at < text.size();) {
    const bool quoted = text[at] == '"';
    const std::size_t begin = at + (quoted ? 1 : 0);
    const std::size_t end =
        std::min(quoted ? text.find('"', begin) : text.find_first_of(" \t", begin), text.size());
    all.push_back(text.substr(begin, end - begin));
    at = text.find_first_not_of(" \t", std::min(end + (quoted ? 1 : 0), text.size()));
  }
  return all;
}

void checkFinite(const TextFields& fields, const std::string& key, const std::string& name,
                 const std::string& what) {
  const auto found = fields.find(key);
  if (found == fields.end()) return;
  for (const double value : numbers(found->second))
    if (!std::isfinite(value))
      throw Error(ErrorCode::Geometry, what + " has " + name + " that is not finite; correct its header.");
}

/// An axis of vector components may have spacing NaN; the three others need a real one.
void checkSpacing(const TextFields& fields, const std::string& key, const std::string& what) {
  const auto found = fields.find(key);
  if (found == fields.end()) return;
  int positive = 0;
  bool bad = false;
  for (const double value : numbers(found->second)) {
    positive += std::isfinite(value) && value > 0;
    bad = bad || std::isinf(value) || value <= 0;
  }
  if (bad || positive < 3)
    throw Error(ErrorCode::Geometry,
                what + " has a voxel spacing that is not finite and above zero; correct its header.");
}

/// NRRD's thicknesses along the three axes of space; 0 where unknown (NaN).
std::array<double, 3> thicknesses(const TextFields& fields) {
  std::array<double, 3> result{};
  const auto found = fields.find("thicknesses");
  if (found == fields.end()) return result;
  std::vector<std::string> values = words(found->second);
  if (const auto kinds = fields.find("kinds"); values.size() > 3 && kinds != fields.end()) {
    const std::vector<std::string> axes = words(kinds->second);
    if (axes.size() != values.size()) return result;
    std::vector<std::string> spatial;
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
      if (axes[axis] == "domain" || axes[axis] == "space") spatial.push_back(values[axis]);
    values = spatial;
  }
  if (values.size() != 3) return result;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const auto value = wholeTextNumber(values[axis]); value && std::isfinite(*value) && *value > 0)
      result[axis] = *value;
  return result;
}

/// Some writers leave ElementSize at its default, 1: within the slices it must agree with the spacing.
std::array<double, 3> elementSizes(const TextFields& fields) {
  std::array<double, 3> result{};
  const auto size = fields.find("ElementSize"), spacing = fields.find("ElementSpacing");
  if (size == fields.end() || spacing == fields.end()) return result;
  const std::vector<double> sizes = numbers(size->second), spacings = numbers(spacing->second);
  if (sizes.size() < 3 || spacings.size() < 3) return result;
  std::array<bool, 3> differs{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    differs[axis] = !(std::abs(sizes[axis] - spacings[axis]) <= 1e-3 * spacings[axis]);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (differs[axis] && !differs[(axis + 1) % 3] && !differs[(axis + 2) % 3] && std::isfinite(sizes[axis]) &&
        sizes[axis] > 0)
      result[axis] = sizes[axis];
  return result;
}

} // namespace

NrrdHeader::NrrdHeader(const std::filesystem::path& path, const std::string& what) {
  const TextHeader header = readHeader(path, ':', "");
  const TextFields& fields = header.fields;
  for (const char* key : {"type", "dimension", "sizes", "encoding"})
    if (!fields.contains(key))
      throw Error(ErrorCode::FileFormat,
                  what + " is not a NRRD image or is damaged (no '" + key + "'); export it again.");
  // NrrdIO copies an unparsable line to a buffer of fixed size, whatever the line's length.
  if (constexpr std::size_t most = 512; header.longestField > most)
    throw Error(ErrorCode::FileFormat, what + " has a damaged header (a line of " +
                                           std::to_string(header.longestField) +
                                           " characters); export it again.");
  if (numbers(fields.at("sizes")).size() >= 3) checkSpacing(fields, "spacings", what);
  checkFinite(fields, "space directions", "a direction", what);
  checkFinite(fields, "space origin", "an origin", what);
  thickness = thicknesses(fields);
  const auto kinds = fields.find("kinds");
  sequence = kinds != fields.end() && kinds->second.find("list") != std::string::npos;
  if (!sequence) return;
  const std::vector<std::string> axes = words(kinds->second);
  const auto list = static_cast<std::size_t>(std::find(axes.begin(), axes.end(), "list") - axes.begin());
  const auto ofList = [&](const char* field) {
    const auto found = fields.find(field);
    const std::vector<std::string> all =
        found == fields.end() ? std::vector<std::string>{} : words(found->second);
    return list < all.size() ? all[list] : std::string();
  };
  indexName = ofList("labels");
  indexUnit = ofList("units");
  if (const auto found = fields.find("axis " + std::to_string(list) + " index values"); found != fields.end())
    for (const std::string& word : words(found->second.substr(found->second.starts_with('=') ? 1 : 0))) {
      const auto value = wholeTextNumber(word);
      if (!value) {
        indexValues.clear();
        break;
      }
      indexValues.push_back(*value);
    }
}

MetaHeader::MetaHeader(const std::filesystem::path& path, const std::string& what) {
  const TextHeader header = readHeader(path, '=', "ElementDataFile");
  const TextFields& fields = header.fields;
  for (const char* key : {"NDims", "DimSize", "ElementType", "ElementDataFile"})
    if (!fields.contains(key))
      throw Error(ErrorCode::FileFormat,
                  what + " is not a MetaImage or is damaged (no '" + key + "'); export it again.");
  if (numbers(fields.at("DimSize")).size() >= 3) checkSpacing(fields, "ElementSpacing", what);
  for (const char* key : {"TransformMatrix", "Rotation", "Orientation"})
    checkFinite(fields, key, "a direction", what);
  for (const char* key : {"Offset", "Position", "Origin"})
    checkFinite(fields, key, "an origin", what);

  const auto isTrue = [&](const char* key, bool otherwise) {
    const auto found = fields.find(key);
    return found == fields.end() ? otherwise
                                 : found->second.starts_with('T') || found->second.starts_with('t');
  };
  for (const auto& [key, value] : fields)
    tracked = tracked || (key.starts_with("Seq_Frame") && key.ends_with("Transform"));
  thickness = elementSizes(fields);
  if (tracked) this->fields = fields;
  binary_ = isTrue("BinaryData", false);
  compressed_ = isTrue("CompressedData", false);
  const std::string& data = fields.at("ElementDataFile");
  if (data == "LOCAL" || data == "Local" || data == "local") {
    voxelFile_ = path;
    voxelsStart_ = header.end;
  } else if (!data.starts_with("LIST") && data.find('%') == std::string::npos) {
    voxelFile_ = path.parent_path() / pathOf(data);
    if (!std::filesystem::is_regular_file(voxelFile_))
      throw Error(ErrorCode::FileFormat, what + " lacks its voxel file '" + data + "'; copy both files.");
  }
}

bool MetaHeader::holds(std::uint64_t bytes) const {
  if (voxelFile_.empty() || !binary_) return true;
  const std::uint64_t length = std::filesystem::file_size(voxelFile_);
  if (!compressed_) return length >= voxelsStart_ && length - voxelsStart_ >= bytes;
  std::ifstream in(voxelFile_, std::ios::binary);
  return inflatedBytes(in, voxelsStart_) >= bytes;
}

} // namespace innergs
