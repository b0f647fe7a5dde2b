#pragma once
#include "Core/Features/EmbeddingTraining.h"

#include <filesystem>

namespace innergs {

/// A dense teacher's features: a NIfTI, NRRD or MetaImage file with several values per voxel. Throws as
/// readVolume() does, and Error(UnsupportedImage) for a single value per voxel.
EmbeddingVolume readEmbeddingVolume(const std::filesystem::path& path);

} // namespace innergs
