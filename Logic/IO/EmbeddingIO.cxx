#include "IO/EmbeddingIO.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "IO/ImageReading.h"

namespace innergs {

EmbeddingVolume readEmbeddingVolume(const std::filesystem::path& path) {
  VectorImage loaded = loadVectors(path);
  if (loaded.components.size() < 2)
    throw Error(ErrorCode::UnsupportedImage,
                quoted(path) + " has one value per voxel; give a feature volume, with several per voxel.");
  return {loaded.geometry, std::move(loaded.components)};
}

} // namespace innergs
