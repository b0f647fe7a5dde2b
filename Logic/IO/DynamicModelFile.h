#pragma once
#include "Core/Motion/DynamicJob.h"
#include "IO/ModelFile.h"

namespace innergs {

/// Writes a model file of a moving scan (.innergs): like ModelFile.h, with the canonical field, the frame
/// times and the splines in time; see Docs/model-format.md. state: of a stopped fit, to resume from the file;
/// features: of the canonical Gaussians. Throws Error(Io).
void writeDynamicModel(const DynamicField& field, const std::filesystem::path& path,
                       const ModelNotes& notes = {}, const RefinementState& state = {},
                       const FeatureModel* features = nullptr);

/// Checks everything before use. Throws Error(FileNotFound | FileFormat | Memory).
DynamicField readDynamicModel(const std::filesystem::path& path, ModelNotes* notes = nullptr,
                              RefinementState* state = nullptr,
                              std::optional<FeatureModel>* features = nullptr);

/// A stopped fit, for DynamicJob::resume(). Throws as readDynamicModel() does.
std::shared_ptr<const StoppedDynamicFit> readStoppedFit(const std::filesystem::path& path);

/// Whether the file is a model of a moving scan; false for anything unreadable.
bool isDynamicModel(const std::filesystem::path& path);

} // namespace innergs
