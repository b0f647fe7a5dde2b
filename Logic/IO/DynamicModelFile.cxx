#include "IO/DynamicModelFile.h"

#include "Core/Base/NumberText.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/MemoryCheck.h"
#include "IO/ModelMetadata.h"

namespace innergs {
namespace {

std::string splineText(const TimeSpline& spline) {
  return json{{"start", spline.start}, {"end", spline.end}, {"coefficients", spline.coefficients}}.dump();
}

TimeSpline splineFrom(const Metadata& metadata, const std::string& key) {
  const json value = metadata.parsed(key);
  if (!value.is_object()) metadata.fail(key);
  for (const char* part : {"start", "end", "coefficients"})
    if (!value.contains(part)) metadata.fail(key);
  constexpr std::uint64_t most = 1 << 16;
  if (!value["coefficients"].is_number_unsigned() || value["coefficients"].get<std::uint64_t>() > most)
    metadata.fail(key);
  return {metadata.number(value["start"], key), metadata.number(value["end"], key),
          value["coefficients"].get<int>()};
}

MotionGrid motionGridFrom(const Metadata& metadata) {
  const std::string key = "motion_lattice";
  const json value = metadata.parsed(key);
  if (!value.is_object()) metadata.fail(key);
  for (const char* part : {"size", "origin", "spacing"})
    if (!value.contains(part)) metadata.fail(key);
  const json& size = value["size"];
  if (!size.is_array() || size.size() != 3) metadata.fail(key);
  MotionGrid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!size[a].is_number_unsigned() || size[a].get<std::uint64_t>() > 4096) metadata.fail(key);
    grid.size[a] = size[a].get<std::int64_t>();
  }
  grid.origin = metadata.vector(value["origin"], key);
  grid.spacing = metadata.vector(value["spacing"], key);
  return grid;
}

std::string networkText(const DeformationNetwork& network) {
  json levels = json::array();
  for (const auto& level : network.levels)
    levels.push_back({{"size", level.size}, {"times", level.times}});
  return json{{"low", network.low},
              {"high", network.high},
              {"start", network.start},
              {"end", network.end},
              {"scale", network.scale},
              {"levels", levels},
              {"channels", DeformationNetwork::kChannels},
              {"width", DeformationNetwork::kWidth}}
      .dump();
}

DeformationNetwork networkFrom(const Metadata& metadata) {
  const std::string key = "deformation_network";
  const json value = metadata.parsed(key);
  if (!value.is_object()) metadata.fail(key);
  for (const char* part : {"low", "high", "start", "end", "scale", "levels", "channels", "width"})
    if (!value.contains(part)) metadata.fail(key);
  DeformationNetwork network;
  if (value["channels"] != DeformationNetwork::kChannels || value["width"] != DeformationNetwork::kWidth)
    metadata.fail(key);
  network.low = metadata.vector(value["low"], key);
  network.high = metadata.vector(value["high"], key);
  network.start = metadata.number(value["start"], key);
  network.end = metadata.number(value["end"], key);
  const json &scale = value["scale"], &levels = value["levels"];
  if (!scale.is_array() || scale.size() != network.scale.size()) metadata.fail(key);
  for (std::size_t i = 0; i < network.scale.size(); ++i)
    network.scale[i] = static_cast<float>(metadata.number(scale[i], key));
  if (!levels.is_array() || levels.empty() || levels.size() > 4) metadata.fail(key);
  const auto nodes = [&](const json& count) {
    if (!count.is_number_unsigned() || count.get<std::uint64_t>() > 4096) metadata.fail(key);
    return count.get<int>();
  };
  for (const json& entry : levels) {
    if (!entry.is_object() || !entry.contains("size") || !entry.contains("times") ||
        !entry["size"].is_array() || entry["size"].size() != 3)
      metadata.fail(key);
    DeformationNetwork::Level level;
    for (std::size_t a = 0; a < 3; ++a)
      level.size[a] = nodes(entry["size"][a]);
    level.times = nodes(entry["times"]);
    network.levels.push_back(level);
  }
  return network;
}

/// Empty unless the fit was stopped midway.
RefinementState refinementFrom(const SafetensorsFile& file, const Metadata& metadata) {
  RefinementState state;
  const auto* moments = file.find("refinement_moments");
  if (!moments) return state;
  const std::string key = "refinement";
  const json value = metadata.parsed(key);
  if (!value.is_object()) metadata.fail(key);
  for (const char* part : {"step", "mse", "key", "steps"})
    if (!value.contains(part)) metadata.fail(key);
  const auto count = [&](const json& number) {
    constexpr std::uint64_t most = 100'000'000;
    if (!number.is_number_unsigned() || number.get<std::uint64_t>() > most) metadata.fail(key);
    return number.get<int>();
  };
  state.step = count(value["step"]);
  state.mse = metadata.number(value["mse"], key);
  if (!value["key"].is_string() || !value["steps"].is_array()) metadata.fail(key);
  state.key = value["key"].get<std::string>();
  for (const json& steps : value["steps"])
    state.steps.push_back(count(steps));
  state.moments = file.read("refinement_moments", moments->shape);
  return state;
}

std::vector<std::int64_t> nodesShape(const DynamicField& field) {
  const auto& n = field.motionGrid.size;
  return {field.motion.coefficients, n[2], n[1], n[0], MotionGrid::kValues};
}

} // namespace

ModelNotes notesOf(const DynamicResult& result, const std::string& inputs) {
  return {{"Version", INNERGS_VERSION},
          {"Inputs", inputs},
          {"Settings", dynamicSettingsText(result.settings)},
          {"InstructionSet", result.instructionSet},
          {"Device", result.device.id},
          {"TrainingPSNR", formatted("%.3f", result.trainingPsnr)}};
}

void writeDynamicModel(const DynamicField& field, const std::filesystem::path& path, const ModelNotes& notes,
                       const RefinementState& state, const FeatureModel* features) {
  checkDynamicField(field);
  Model model;
  model.field = field.canonical;
  model.finished = field.size();
  std::map<std::string, std::string> more{{"moving", dynamicKindName(field.kind)},
                                          {"times", json(field.times).dump()}};
  std::vector<TensorToWrite> tensors;
  const auto add = [&](const char* name, std::vector<std::int64_t> shape, const std::vector<float>& values) {
    tensors.push_back({name, std::move(shape), [&values] { return values; }});
  };
  if (field.kind == DynamicKind::Motion) {
    more["motion_lattice"] = json{{"size", field.motionGrid.size},
                                  {"origin", field.motionGrid.origin},
                                  {"spacing", field.motionGrid.spacing}}
                                 .dump();
    more["motion_spline"] = splineText(field.motion);
    add("motion_nodes", nodesShape(field), field.nodes);
    add("anchor", {field.size(), 3}, field.anchors);
    if (!field.ownPath.empty()) {
      more["own_spline"] = splineText(field.own);
      add("own_path", {field.own.coefficients, field.size(), 3}, field.ownPath);
    }
  } else if (field.kind == DynamicKind::Network) {
    more["deformation_network"] = networkText(field.network);
    add("anchor", {field.size(), 3}, field.anchors);
    add("deformation", {static_cast<std::int64_t>(field.network.parameters.size())},
        field.network.parameters);
  } else {
    more["change_spline"] = splineText(field.change);
    add("intensity_change", {field.change.coefficients, field.size()}, field.changes);
  }
  if (features) addFeatures(*features, field.canonical, more, tensors);
  if (!state.empty()) {
    more["refinement"] =
        json{{"step", state.step}, {"mse", state.mse}, {"key", state.key}, {"steps", state.steps}}.dump();
    add("refinement_moments", {static_cast<std::int64_t>(state.moments.size())}, state.moments);
  }
  writeModelWith(model, path, notes, more, std::move(tensors));
}

DynamicField readDynamicModel(const std::filesystem::path& path, ModelNotes* notes, RefinementState* state,
                              std::optional<FeatureModel>* features) {
  if (features) features->reset();
  const SafetensorsFile file(path);
  if (!isDynamic(file))
    throw Error(ErrorCode::FileFormat,
                quoted(path) + " is not a model of a dynamic scan; choose another file.");
  DynamicField field;
  field.canonical = readModelFrom(file, path, notes, features).field;
  const Metadata metadata(file, path);
  const auto kind = dynamicKindNamed(metadata.text("moving"));
  if (!kind) metadata.fail("moving");
  field.kind = *kind;
  const json times = metadata.parsed("times");
  if (!times.is_array()) metadata.fail("times");
  for (const json& time : times)
    field.times.push_back(metadata.number(time, "times"));
  const auto read = [&](const char* name, const std::vector<std::int64_t>& shape) {
    double count = sizeof(float);
    for (const std::int64_t n : shape)
      count *= static_cast<double>(n);
    checkMemoryFor(count, quoted(path));
    return file.read(name, shape);
  };
  if (field.kind == DynamicKind::Motion) {
    field.motionGrid = motionGridFrom(metadata);
    field.motion = splineFrom(metadata, "motion_spline");
    field.nodes = read("motion_nodes", nodesShape(field));
    field.anchors = read("anchor", {field.size(), 3});
    if (file.find("own_path")) {
      field.own = splineFrom(metadata, "own_spline");
      field.ownPath = read("own_path", {field.own.coefficients, field.size(), 3});
    }
  } else if (field.kind == DynamicKind::Network) {
    field.network = networkFrom(metadata);
    field.anchors = read("anchor", {field.size(), 3});
    field.network.parameters =
        read("deformation", {static_cast<std::int64_t>(field.network.parameterCount())});
  } else {
    field.change = splineFrom(metadata, "change_spline");
    field.changes = read("intensity_change", {field.change.coefficients, field.size()});
  }
  checkDynamicField(field);
  if (state) *state = refinementFrom(file, metadata);
  return field;
}

std::shared_ptr<const StoppedDynamicFit> readStoppedFit(const std::filesystem::path& path) {
  auto stopped = std::make_shared<StoppedDynamicFit>();
  std::optional<FeatureModel> features;
  stopped->field = readDynamicModel(path, nullptr, &stopped->state, &features);
  stopped->knowsSegments = features.has_value();
  return stopped;
}

AnyModel readAnyModel(const std::filesystem::path& path) {
  AnyModel any;
  std::optional<FeatureModel> features;
  if (isDynamicModel(path))
    any.field = std::make_shared<const DynamicField>(readDynamicModel(path, &any.notes, nullptr, &features));
  else
    any.model = std::make_shared<const Model>(readModel(path, &any.notes, &features));
  if (features) any.features = std::make_shared<const FeatureModel>(std::move(*features));
  return any;
}

bool isDynamicModel(const std::filesystem::path& path) {
  try {
    return fullExtension(path) == ".innergs" && isDynamic(SafetensorsFile(path));
  } catch (const Error&) {
    return false;
  }
}

} // namespace innergs
