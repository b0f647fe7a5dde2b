#pragma once
#include "Core/Motion/DynamicField.h"
#include "IO/ModelFile.h"

namespace innergs {

/// Writes a model file of a moving scan (.innergs): like ModelFile.h, with the canonical field, the frame
/// times and the splines in time; see Docs/model-format.md. Throws Error(Io).
void writeDynamicModel(const DynamicField& field, const std::filesystem::path& path,
                       const ModelNotes& notes = {});

/// Checks everything before use. Throws Error(FileNotFound | FileFormat | Memory).
DynamicField readDynamicModel(const std::filesystem::path& path, ModelNotes* notes = nullptr);

/// Whether the file is a model of a moving scan; false for anything unreadable.
bool isDynamicModel(const std::filesystem::path& path);

} // namespace innergs
