#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Job/ReconstructionJob.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace innergs {

/// How a model was made, in readable form: "Version", "Inputs", "Settings", "Device", "TrainingPSNR" and the
/// like, text to text. Optional in a file.
using ModelNotes = std::map<std::string, std::string>;

/// The notes of a reconstruction's model. inputs, mask: names; "" without a mask. settings: settingsText().
ModelNotes notesOf(const ReconstructionResult& result, const std::string& inputs, const std::string& mask,
                   const std::string& settings);

/// Writes a model file (.innergs): a safetensors container (8-byte little-endian header length, JSON header,
/// raw little-endian tensors), so any safetensors reader opens it; format and version in
/// Docs/model-format.md. `features`: of the model's Gaussians; null: none. Throws Error(Io),
/// Error(FileFormat) if the features do not match.
void writeModel(const Model& model, const std::filesystem::path& path, const ModelNotes& notes = {},
                const FeatureModel* features = nullptr);

/// Reads a model file, or a PLY file of Gaussians as a model without residual grid and fit state (Ply.h).
/// Checks every length, offset, shape and value before use. Throws Error(FileNotFound | FileFormat | Memory).
/// `notes`: receives the file's notes, empty if it has none; likewise `features`.
Model readModel(const std::filesystem::path& path, ModelNotes* notes = nullptr,
                std::optional<FeatureModel>* features = nullptr);

} // namespace innergs
