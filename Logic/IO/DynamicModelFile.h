#pragma once
#include "Core/Motion/DynamicField.h"
#include "IO/ModelFile.h"

namespace innergs {

/// Model files of moving scans (.innergs): as ModelFile.h has them, with the canonical field, the frames'
/// times and the splines in time; Docs/model-format.md. Throws Error(Io).
void writeDynamicModel(const DynamicField& field, const std::filesystem::path& path,
                       const ModelNotes& notes = {});

/// Everything is checked before use. Throws Error(FileNotFound | FileFormat | Memory).
DynamicField readDynamicModel(const std::filesystem::path& path, ModelNotes* notes = nullptr);

/// Whether the file is a model of a moving scan; false for whatever cannot be read.
bool isDynamicModel(const std::filesystem::path& path);

} // namespace innergs
