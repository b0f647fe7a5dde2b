#include "IO/ModelMetadata.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "IO/MemoryCheck.h"
#include "IO/Safetensors.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace innergs {
namespace {

constexpr int formatVersion = 1, dynamicVersion = 2; // static models keep version 1
constexpr int floatsPerGaussian = 16;
static_assert(sizeof(Gaussian) == floatsPerGaussian * sizeof(float));

/// Position of a tensor within the sixteen floats of a Gaussian.
struct Part {
  const char* name;
  int first, count;
};
constexpr Part parts[] = {{"mean", 0, 3},        {"log_scale", 3, 3},  {"quaternion", 6, 4},
                          {"log_weight", 10, 1}, {"intensity", 11, 1}, {"slope", 12, 3}};
constexpr int slopePart = 5;

const float* floats(const Gaussian& gaussian) {
  return reinterpret_cast<const float*>(&gaussian);
}
float* floats(Gaussian& gaussian) {
  return reinterpret_cast<float*>(&gaussian);
}

std::vector<std::int64_t> shapeOf(const Part& part, std::int64_t count) {
  if (part.count == 1) return {count};
  return {count, part.count};
}

json toJson(const Vec3& v) {
  return {v[0], v[1], v[2]};
}
json toJson(const Mat3& m) {
  return {toJson(m[0]), toJson(m[1]), toJson(m[2])};
}

json toJson(const GridGeometry& grid) {
  return {{"size", grid.size},
          {"origin", toJson(grid.origin)},
          {"spacing", toJson(grid.spacing)},
          {"direction", toJson(grid.direction)}};
}
std::vector<std::int64_t> residualShape(const GridGeometry& grid) {
  return {grid.size[2], grid.size[1], grid.size[0]};
}

/// Run lengths of equal voxels in memory order, starting with a run outside (0 if the first voxel is inside).
std::vector<std::uint32_t> runsOf(const Mask& mask) {
  std::vector<std::uint32_t> runs{0};
  bool inside = false;
  for (const std::uint8_t voxel : mask.voxels) {
    if ((voxel != 0) != inside) {
      runs.push_back(0);
      inside = !inside;
    }
    if (runs.back() == std::numeric_limits<std::uint32_t>::max()) runs.insert(runs.end(), {0, 0});
    ++runs.back();
  }
  return runs;
}

std::vector<std::uint8_t> voxelsOf(const std::vector<std::uint32_t>& runs) {
  std::vector<std::uint8_t> voxels;
  for (std::size_t n = 0; n < runs.size(); ++n)
    voxels.insert(voxels.end(), runs[n], static_cast<std::uint8_t>(n % 2));
  return voxels;
}

std::map<std::string, std::string> metadataOf(const Model& model) {
  const GaussianField& field = model.field;
  const Mat3& r = field.modelToWorld.linear;
  const Vec3& t = field.modelToWorld.offset;
  const json pose = {r[0][0], r[0][1], r[0][2], t[0], r[1][0], r[1][1], r[1][2], t[1],
                     r[2][0], r[2][1], r[2][2], t[2], 0.0,     0.0,     0.0,     1.0};
  std::map<std::string, std::string> metadata{
      {"format", "InnerGS"},
      {"format_version", std::to_string(formatVersion)},
      {"program", "InnerGS " INNERGS_VERSION},
      {"frame", "mean, log_scale, quaternion and slope in the model frame; model_to_world (row-major "
                "4x4) maps it to LPS "
                "patient space"},
      {"units", "lengths in mm; log_scale = ln(mm); slope per mm; scanner value = intensity_scale * value + "
                "intensity_offset"},
      {"blending", blendingName(field.blending)},
      {"epsilon", json(field.epsilon).dump()},
      {"cutoff", json(field.cutoff).dump()},
      {"model_to_world", pose.dump()},
      {"intensity_scale", json(field.intensityScale).dump()},
      {"intensity_offset", json(field.intensityOffset).dump()},
      {"domain", toJson(field.domain).dump()},
      {"iteration", std::to_string(model.iteration)},
      {"finished_gaussians", std::to_string(model.finished)},
      {"settings_key", model.settingsKey}};
  if (!field.residual.voxels.empty()) metadata["detail_grid"] = toJson(field.residual.geometry).dump();
  if (!field.support.voxels.empty()) {
    metadata["support_grid"] = toJson(field.support.geometry).dump();
    metadata["fill_value"] = json(field.fill).dump();
  }
  if (field.range) metadata["value_range"] = json({field.range->low, field.range->high}).dump();
  return metadata;
}

json featuresJson(const FeatureModel& features) {
  json value{{"names", features.names},
             {"labels", features.labels},
             {"blocks", toJson(features.support.blocks)},
             {"low_intensity", features.scale.low}};
  if (features.decoder) value["embedding_size"] = features.decoder->size;
  if (!features.residual.empty()) value["residual_grid"] = toJson(features.residual.grid);
  if (features.time != 0) value["time"] = features.time;
  return value;
}

/// Adds tensors that refer to the features.
void addTensors(const FeatureModel& features, std::vector<TensorToWrite>& tensors) {
  const std::int64_t channels = features.channels, classes = features.classes(),
                     words = features.support.words;
  const auto add = [&](const char* name, std::vector<std::int64_t> shape, const std::vector<float>& values) {
    tensors.push_back({name, std::move(shape), [&values] { return values; }});
  };
  add("feature_latents", {static_cast<std::int64_t>(features.latents.size()) / channels, channels},
      features.latents);
  if (features.decoder) {
    add("feature_embeddings", {classes, features.decoder->size}, features.embeddings);
    add("feature_decoder", {static_cast<std::int64_t>(features.decoder->parameters.size())},
        features.decoder->parameters);
  } else {
    add("feature_codes", {classes, FeatureModel::kTerms, channels}, features.codes);
  }
  if (!features.scale.knots.empty())
    add("feature_ranks", {static_cast<std::int64_t>(features.scale.knots.size())}, features.scale.knots);
  tensors.push_back({"feature_support", {features.support.blocks.voxelCount(), words}, [&features] {
                       return features.support.bits;
                     }});
  const ClassResidual& residual = features.residual;
  if (residual.empty()) return;
  const auto voxels = static_cast<std::int64_t>(residual.voxels.size());
  tensors.push_back({"feature_residual_voxels", {voxels}, [&residual] { return residual.voxels; }});
  tensors.push_back({"feature_residual_ends", {voxels}, [&residual] { return residual.ends; }});
  tensors.push_back({"feature_residual", {static_cast<std::int64_t>(residual.entries.size())}, [&residual] {
                       return residual.entries;
                     }});
}

ClassResidual residualOf(const SafetensorsFile& file, const GridGeometry& grid, const Metadata& metadata,
                         const std::filesystem::path& path) {
  ClassResidual residual;
  residual.grid = grid;
  const auto read = [&](const char* name) {
    const auto* tensor = file.find(name);
    if (tensor == nullptr || tensor->shape.size() != 1) metadata.fail(name);
    checkMemoryFor(4 * static_cast<double>(tensor->shape[0]), quoted(path));
    return file.readUnsigned(name, tensor->shape);
  };
  residual.voxels = read("feature_residual_voxels");
  residual.ends = read("feature_residual_ends");
  residual.entries = read("feature_residual");
  return residual;
}

FeatureModel featuresOf(const SafetensorsFile& file, const Metadata& metadata, const GaussianField& field,
                        const std::filesystem::path& path) {
  FeatureModel features;
  const json value = metadata.parsed("features");
  if (!value.is_object() || !value.contains("names") || !value.contains("labels")) metadata.fail("features");
  const json &names = value["names"], &labels = value["labels"];
  if (!names.is_array() || !labels.is_array() || names.size() < 2 || names.size() > 65535)
    metadata.fail("features");
  for (const json& name : names) {
    if (!name.is_string()) metadata.fail("features");
    features.names.push_back(name.get<std::string>());
  }
  for (const json& label : labels) {
    if (!label.is_number_unsigned() || label.get<std::uint64_t>() > 65535) metadata.fail("features");
    features.labels.push_back(label.get<std::uint16_t>());
  }
  features.support.blocks = metadata.gridOf(value.value("blocks", json()), "features");
  const auto* latents = file.find("feature_latents");
  if (latents == nullptr || latents->shape.size() != 2 || latents->shape[1] < 1 || latents->shape[1] > 32)
    metadata.fail("feature_latents");
  features.channels = static_cast<int>(latents->shape[1]);
  features.support.words = (features.classes() + 31) / 32;
  const auto& n = features.support.blocks.size;
  const double blocks = static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
  checkMemoryFor(
      4 * (static_cast<double>(field.size()) * features.channels + blocks * features.support.words),
      quoted(path));
  features.latents = file.read("feature_latents", {field.size(), features.channels});
  if (value.contains("embedding_size")) {
    const json& size = value["embedding_size"];
    if (!size.is_number_unsigned() || size.get<std::uint64_t>() < 1 || size.get<std::uint64_t>() > 65536)
      metadata.fail("features");
    EmbeddingDecoder& decoder = features.decoder.emplace();
    decoder.channels = features.channels;
    decoder.size = size.get<int>();
    features.embeddings = file.read("feature_embeddings", {features.classes(), decoder.size});
    decoder.parameters = file.read("feature_decoder", {static_cast<std::int64_t>(decoder.layers()[1].end())});
  } else {
    features.codes =
        file.read("feature_codes", {features.classes(), FeatureModel::kTerms, features.channels});
  }
  if (const auto* ranks = file.find("feature_ranks")) {
    if (ranks->shape.size() != 1 || ranks->shape[0] > 65536) metadata.fail("feature_ranks");
    features.scale.knots = file.read("feature_ranks", ranks->shape);
    features.scale.low =
        static_cast<float>(metadata.number(value.value("low_intensity", json()), "features"));
  }
  const auto* support = file.find("feature_support");
  if (support == nullptr || support->shape.size() != 2 || static_cast<double>(support->shape[0]) != blocks)
    metadata.fail("feature_support");
  features.support.bits = file.readUnsigned("feature_support", {support->shape[0], features.support.words});
  if (value.contains("residual_grid"))
    features.residual = residualOf(file, metadata.gridOf(value["residual_grid"], "features"), metadata, path);
  if (value.contains("time")) features.time = metadata.number(value["time"], "features");
  checkFeatures(features, field);
  return features;
}

} // namespace

bool isDynamic(const SafetensorsFile& file) {
  return file.metadata().contains("moving");
}

void checkFormat(const SafetensorsFile& file, const std::filesystem::path& path) {
  const auto format = file.metadata().find("format");
  if (format == file.metadata().end() || format->second != "InnerGS")
    throw Error(ErrorCode::FileFormat,
                quoted(path) + " is a safetensors file but not an InnerGS model; choose another file.");
  if (Metadata(file, path).integer("format_version") > (isDynamic(file) ? dynamicVersion : formatVersion))
    throw Error(ErrorCode::FileFormat,
                quoted(path) + " was written by a newer version of InnerGS; update InnerGS to open it.");
}

void addFeatures(const FeatureModel& features, const GaussianField& field,
                 std::map<std::string, std::string>& more, std::vector<TensorToWrite>& tensors) {
  checkFeatures(features, field);
  addTensors(features, tensors);
  more["features"] = featuresJson(features).dump(-1, ' ', false, json::error_handler_t::replace);
}

void writeModelWith(const Model& model, const std::filesystem::path& path, const ModelNotes& notes,
                    const std::map<std::string, std::string>& more, std::vector<TensorToWrite> others) {
  const std::vector<Gaussian>& gaussians = model.field.gaussians;
  const std::int64_t count = model.field.size();
  std::vector<TensorToWrite> tensors;
  for (const Part& part : parts) {
    if (&part == &parts[slopePart] && !model.field.linearIntensity) continue;
    tensors.push_back({part.name, shapeOf(part, count), [&gaussians, part] {
                         std::vector<float> values;
                         values.reserve(gaussians.size() * static_cast<std::size_t>(part.count));
                         for (const Gaussian& gaussian : gaussians)
                           values.insert(values.end(), floats(gaussian) + part.first,
                                         floats(gaussian) + part.first + part.count);
                         return values;
                       }});
  }
  const auto addMoment = [&](const char* name, const std::vector<float>& moment) {
    if (moment.empty()) return;
    const std::int64_t open = count - model.finished;
    if (open < 1 || moment.size() != static_cast<std::size_t>(open) * floatsPerGaussian)
      throw Error(ErrorCode::Internal,
                  "The optimiser's state does not match the Gaussians; please report this.");
    tensors.push_back({name, {open, floatsPerGaussian}, [&moment] { return moment; }});
  };
  addMoment("adam_moment1", model.optimizer.moment1);
  addMoment("adam_moment2", model.optimizer.moment2);
  const auto addValues = [&](const char* name, const std::vector<float>& values) {
    if (!values.empty())
      tensors.push_back({name, {static_cast<std::int64_t>(values.size())}, [&values] { return values; }});
  };
  addValues("losses", model.optimizer.losses);
  addValues("pulls", model.optimizer.gradients);
  const Volume& residual = model.field.residual;
  if (!residual.voxels.empty())
    tensors.push_back({"detail", residualShape(residual.geometry), [&residual] { return residual.voxels; }});
  std::vector<std::uint32_t> runs;
  if (!model.field.support.voxels.empty()) runs = runsOf(model.field.support);
  if (!runs.empty())
    tensors.push_back({"support", {static_cast<std::int64_t>(runs.size())}, [&runs] { return runs; }});
  auto metadata = metadataOf(model);
  if (more.contains("moving")) metadata["format_version"] = std::to_string(dynamicVersion);
  metadata.insert(more.begin(), more.end());
  std::move(others.begin(), others.end(), std::back_inserter(tensors));
  if (!notes.empty()) // node names may be in any encoding
    metadata["notes"] = json(notes).dump(-1, ' ', false, json::error_handler_t::replace);
  writeSafetensors(path, metadata, tensors);
}

Model readModelFrom(const SafetensorsFile& file, const std::filesystem::path& path, ModelNotes* notes,
                    std::optional<FeatureModel>* features) {
  checkFormat(file, path);
  const Metadata metadata(file, path);
  const SafetensorsFile::Tensor* mean = file.find("mean");
  if (mean == nullptr || mean->shape.size() != 2) metadata.fail("mean");
  const std::int64_t count = mean->shape[0];
  const bool resumable = file.find("adam_moment1") != nullptr;
  checkMemoryFor(double(count) * sizeof(Gaussian) * (resumable ? 3 : 1), quoted(path));

  Model model;
  GaussianField& field = model.field;
  const auto blending = blendingNamed(metadata.text("blending"));
  if (!blending) metadata.fail("blending");
  field.blending = *blending;
  field.linearIntensity = file.find("slope") != nullptr;
  field.epsilon = metadata.number("epsilon");
  field.cutoff = metadata.number("cutoff");
  field.modelToWorld = metadata.pose("model_to_world");
  field.intensityScale = metadata.number("intensity_scale");
  field.intensityOffset = metadata.number("intensity_offset");
  field.domain = metadata.grid("domain");
  model.iteration = metadata.integer("iteration");
  model.finished = metadata.integer("finished_gaussians");
  if (model.finished > count) metadata.fail("finished_gaussians");
  model.settingsKey = metadata.text("settings_key");

  field.gaussians.assign(static_cast<std::size_t>(count), Gaussian{});
  for (const Part& part : parts) {
    if (&part == &parts[slopePart] && !field.linearIntensity) continue;
    const std::vector<float> values = file.read(part.name, shapeOf(part, count));
    for (std::size_t i = 0; i < field.gaussians.size(); ++i)
      std::copy_n(values.data() + i * static_cast<std::size_t>(part.count), part.count,
                  floats(field.gaussians[i]) + part.first);
  }
  if (resumable) {
    const std::int64_t open = count - model.finished;
    model.optimizer.moment1 = file.read("adam_moment1", {open, floatsPerGaussian});
    model.optimizer.moment2 = file.read("adam_moment2", {open, floatsPerGaussian});
    for (const std::vector<float>* moment : {&model.optimizer.moment1, &model.optimizer.moment2})
      for (const float value : *moment)
        if (!(std::fabs(value) <= 1e30f) || (moment == &model.optimizer.moment2 && value < 0))
          metadata.fail("adam_moment1, adam_moment2");
    const auto readValues = [&](const char* name, std::int64_t atMost) -> std::vector<float> {
      const SafetensorsFile::Tensor* tensor = file.find(name);
      if (tensor == nullptr) return {};
      if (tensor->shape.size() != 1 || tensor->shape[0] > atMost) metadata.fail(name);
      return file.read(name, tensor->shape);
    };
    model.optimizer.losses = readValues("losses", model.iteration);
    model.optimizer.gradients = readValues("pulls", open);
  }
  if (file.find("detail") != nullptr) {
    field.residual.geometry = metadata.grid("detail_grid");
    field.residual.voxels = file.read("detail", residualShape(field.residual.geometry));
  }
  if (const auto* tensor = file.find("support")) {
    if (tensor->shape.size() != 1) metadata.fail("support");
    const std::vector<std::uint32_t> runs = file.readUnsigned("support", tensor->shape);
    const double voxels = std::accumulate(runs.begin(), runs.end(), 0.0);
    field.support.geometry = metadata.grid("support_grid");
    const auto& n = field.support.geometry.size;
    if (voxels != static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]))
      metadata.fail("support");
    checkMemoryFor(voxels, quoted(path));
    field.support.voxels = voxelsOf(runs);
    field.fill = static_cast<float>(metadata.number("fill_value"));
  }
  if (metadata.has("value_range")) {
    const json range = metadata.parsed("value_range");
    if (!range.is_array() || range.size() != 2) metadata.fail("value_range");
    field.range = {static_cast<float>(metadata.number(range[0], "value_range")),
                   static_cast<float>(metadata.number(range[1], "value_range"))};
  }
  checkField(field);
  if (features && metadata.has("features")) *features = featuresOf(file, metadata, field, path);
  if (notes) *notes = metadata.notes();
  return model;
}

} // namespace innergs
