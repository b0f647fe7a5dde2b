#pragma once
#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/Safetensors.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>

/// Shared by the readers and writers of static and dynamic models.
namespace innergs {

using nlohmann::json;

/// writeModel() with additional entries and tensors; an entry "moving" marks the file as a dynamic model.
void writeModelWith(const Model& model, const std::filesystem::path& path, const ModelNotes& notes,
                    const std::map<std::string, std::string>& more, std::vector<TensorToWrite> others);
/// Entries and tensors of features for writeModelWith(), which refer to them. Throws Error(FileFormat) as
/// checkFeatures().
void addFeatures(const FeatureModel& features, const GaussianField& field,
                 std::map<std::string, std::string>& more, std::vector<TensorToWrite>& tensors);
/// readModel() from an open file, which may hold more.
Model readModelFrom(const SafetensorsFile& file, const std::filesystem::path& path, ModelNotes* notes,
                    std::optional<FeatureModel>* features = nullptr);
/// Whether the file holds a dynamic model.
bool isDynamic(const SafetensorsFile& file);
/// Throws Error(FileFormat) unless the file is a model of a known version.
void checkFormat(const SafetensorsFile& file, const std::filesystem::path& path);

/// Reads typed values from the metadata; throws Error(FileFormat) for anything missing or malformed.
class Metadata {
public:
  Metadata(const SafetensorsFile& file, const std::filesystem::path& path)
      : values_(file.metadata()), path_(path) {}

  [[noreturn]] void fail(const std::string& key) const {
    throw Error(ErrorCode::FileFormat, quoted(path_) + " is not an InnerGS model or is damaged (its entry '" +
                                           key + "' is missing or wrong); save or copy it again.");
  }
  bool has(const std::string& key) const { return values_.find(key) != values_.end(); }
  std::string text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) fail(key);
    return found->second;
  }
  json parsed(const std::string& key) const { return json::parse(text(key), nullptr, false); }
  double number(const json& value, const std::string& key) const {
    if (!value.is_number()) fail(key);
    const double result = value.get<double>();
    if (!std::isfinite(result)) fail(key);
    return result;
  }
  double number(const std::string& key) const { return number(parsed(key), key); }
  Vec3 vector(const json& value, const std::string& key) const {
    if (!value.is_array() || value.size() != 3) fail(key);
    return {number(value[0], key), number(value[1], key), number(value[2], key)};
  }
  int integer(const std::string& key) const {
    const std::string digits = text(key);
    int value = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc{} || end != digits.data() + digits.size() || value < 0) fail(key);
    return value;
  }
  Affine3 pose(const std::string& key) const {
    const json value = parsed(key);
    if (!value.is_array() || value.size() != 16) fail(key);
    Affine3 pose;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        pose.linear[static_cast<int>(row)][axis] = number(value[4 * row + axis], key);
      pose.offset[row] = number(value[4 * row + 3], key);
    }
    return pose;
  }
  ModelNotes notes() const {
    ModelNotes notes;
    if (!has("notes")) return notes; // written by an older version
    const json value = parsed("notes");
    if (!value.is_object()) fail("notes");
    for (const auto& [key, text] : value.items()) {
      if (!text.is_string()) fail("notes");
      notes[key] = text.get<std::string>();
    }
    return notes;
  }
  GridGeometry grid(const std::string& key) const { return gridOf(parsed(key), key); }
  GridGeometry gridOf(const json& value, const std::string& key) const {
    if (!value.is_object()) fail(key);
    for (const char* part : {"size", "origin", "spacing", "direction"})
      if (!value.contains(part)) fail(key);
    GridGeometry grid;
    const json &size = value["size"], &direction = value["direction"];
    if (!size.is_array() || size.size() != 3 || !direction.is_array() || direction.size() != 3) fail(key);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!size[axis].is_number_unsigned() || size[axis].get<std::uint64_t>() > (1u << 30)) fail(key);
      grid.size[axis] = size[axis].get<std::int64_t>();
      grid.direction[static_cast<int>(axis)] = vector(direction[axis], key);
    }
    grid.origin = vector(value["origin"], key);
    grid.spacing = vector(value["spacing"], key);
    try {
      checkGeometry(grid, "the domain");
    } catch (const Error&) {
      fail(key);
    }
    return grid;
  }

private:
  const std::map<std::string, std::string>& values_;
  const std::filesystem::path& path_;
};

} // namespace innergs
