#pragma once
#include "Core/Motion/DynamicJob.h"
#include "IO/ModelFile.h"

namespace innergs {

/// Writes a model file of a dynamic scan (.innergs): like ModelFile.h, with the canonical field, the frame
/// times and the splines in time; see Docs/model-format.md. state: of a stopped fit, to resume from the file;
/// features: of the canonical Gaussians. Throws Error(Io).
void writeDynamicModel(const DynamicField& field, const std::filesystem::path& path,
                       const ModelNotes& notes = {}, const RefinementState& state = {},
                       const FeatureModel* features = nullptr);

/// The notes of a dynamic scan's model. inputs: names.
ModelNotes notesOf(const DynamicResult& result, const std::string& inputs);

/// Checks everything before use. Throws Error(FileNotFound | FileFormat | Memory).
DynamicField readDynamicModel(const std::filesystem::path& path, ModelNotes* notes = nullptr,
                              RefinementState* state = nullptr,
                              std::optional<FeatureModel>* features = nullptr);

/// A stopped fit, for DynamicJob::resume(). Throws as readDynamicModel() does.
std::shared_ptr<const StoppedDynamicFit> readStoppedFit(const std::filesystem::path& path);

/// A model file of either kind: `model` or `field` is set.
struct AnyModel {
  std::shared_ptr<const Model> model;
  std::shared_ptr<const DynamicField> field;    // of a dynamic scan
  std::shared_ptr<const FeatureModel> features; // null: none
  ModelNotes notes;
};
/// Throws as readModel() and readDynamicModel() do.
AnyModel readAnyModel(const std::filesystem::path& path);

/// Whether the file is a model of a dynamic scan; false for anything unreadable.
bool isDynamicModel(const std::filesystem::path& path);

} // namespace innergs
