#pragma once
#include "Core/Features/EmbeddingTraining.h"

#include <filesystem>
#include <vector>

namespace innergs {

/// Embeddings of texts by a dense teacher: JSON, {"liver": [0.1, …], "spleen": […]}. Throws
/// Error(FileNotFound | FileFormat).
std::vector<TextEmbedding> readTextEmbeddings(const std::filesystem::path& path);

} // namespace innergs
