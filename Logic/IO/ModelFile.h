#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Job/ReconstructionJob.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace innergs {

/// What a model was made from, for people: "Version", "Inputs", "Settings", "Device", "TrainingPSNR" and the
/// like, text to text. Optional in a file.
using ModelNotes = std::map<std::string, std::string>;

/// Of a reconstruction's model. inputs, mask: names; no mask: "". settings: settingsText().
ModelNotes notesOf(const ReconstructionResult& result, const std::string& inputs, const std::string& mask,
                   const std::string& settings);

/// Model files (.innergs): a safetensors container (8-byte little-endian header length, JSON header, raw
/// little-endian tensors), so any safetensors reader opens them; format and version in Docs/model-format.md.
/// `features`: of the model's Gaussians; null: none. Throws Error(Io), Error(FileFormat) where they do
/// not fit.
void writeModel(const Model& model, const std::filesystem::path& path, const ModelNotes& notes = {},
                const FeatureModel* features = nullptr);

/// A model file, or a PLY file of Gaussians as a model without residual grid and fit state (Ply.h). Every
/// length, offset, shape and value is checked before use. Throws Error(FileNotFound | FileFormat | Memory).
/// `notes`: receives those of the file, empty when it has none; `features` likewise.
Model readModel(const std::filesystem::path& path, ModelNotes* notes = nullptr,
                std::optional<FeatureModel>* features = nullptr);

} // namespace innergs
