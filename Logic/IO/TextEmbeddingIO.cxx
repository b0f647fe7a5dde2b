#include "IO/TextEmbeddingIO.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"

#include <nlohmann/json.hpp>

#include <fstream>

namespace innergs {

std::vector<TextEmbedding> readTextEmbeddings(const std::filesystem::path& path) {
  using nlohmann::ordered_json;
  checkInputFile(path);
  std::ifstream in(path, std::ios::binary);
  const ordered_json file = ordered_json::parse(in, nullptr, false);
  const auto fail = [&] {
    throw Error(ErrorCode::FileFormat,
                quoted(path) +
                    " does not hold text embeddings; write {\"liver\": [0.1, 0.2], \"spleen\": [0.3, 0.4]}.");
  };
  if (!file.is_object() || file.empty()) fail();
  std::vector<TextEmbedding> texts;
  for (const auto& [name, values] : file.items()) {
    if (!values.is_array() || values.empty() || name.empty()) fail();
    TextEmbedding text{name, {}};
    for (const auto& value : values) {
      if (!value.is_number()) fail();
      text.values.push_back(value.get<float>());
    }
    texts.push_back(std::move(text));
  }
  return texts;
}

} // namespace innergs
