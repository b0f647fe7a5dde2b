#pragma once
#include "Core/ReconstructionJob.h"

#include <filesystem>

namespace innergs {

/// Model files (.innergs): a safetensors container (8-byte little-endian header length, JSON header, raw
/// little-endian tensors), so any safetensors reader opens them; format and version in Docs/model-format.md.
/// Throws Error(Io).
void writeModel(const Checkpoint& checkpoint, const std::filesystem::path& path);

/// Every length, offset, shape and value is checked before use. Throws Error(FileNotFound | FileFormat |
/// Memory).
Checkpoint readModel(const std::filesystem::path& path);

} // namespace innergs
