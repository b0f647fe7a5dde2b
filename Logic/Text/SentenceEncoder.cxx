#include "Text/SentenceEncoder.h"

#include "Core/Base/Error.h"
#include "Core/Base/PathText.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace innergs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBatch = 32; // texts at once

fs::path networkIn(const fs::path& folder) {
  std::error_code none;
  if (!fs::is_directory(folder, none))
    throw Error(ErrorCode::FileNotFound,
                "There is no folder '" + utf8(folder) +
                    "' for the sentence embedding: give one with model.onnx and vocab.txt.");
  for (const char* name : {"model.onnx", "onnx/model.onnx"})
    if (fs::is_regular_file(folder / name, none)) return folder / name;
  throw Error(ErrorCode::FileNotFound, "The folder '" + utf8(folder) +
                                           "' holds neither model.onnx nor onnx/model.onnx: put the sentence "
                                           "embedding's network there, with its vocab.txt.");
}

/// Checks the folder's files in this order, so that the first missing one is named.
fs::path vocabularyIn(const fs::path& folder) {
  networkIn(folder);
  return folder / "vocab.txt";
}

} // namespace

SentenceEncoder::SentenceEncoder(const fs::path& folder)
    : tokens_(vocabularyIn(folder)), network_(networkIn(folder)) {
  const auto& inputs = network_.inputs();
  for (const char* needed : {"input_ids", "attention_mask"})
    if (std::none_of(inputs.begin(), inputs.end(), [&](const auto& port) { return port.name == needed; }))
      throw Error(ErrorCode::InvalidArgument, network_.name() + " has no input '" + needed +
                                                  "': give a sentence embedding such as all-MiniLM-L6-v2.");
  for (const NetworkPort& port : inputs)
    if (port.name != "input_ids" && port.name != "attention_mask" && port.name != "token_type_ids")
      throw Error(ErrorCode::InvalidArgument,
                  network_.name() + " has an input '" + port.name +
                      "', which is unknown: give a sentence embedding such as all-MiniLM-L6-v2.");
}

std::vector<std::vector<float>> SentenceEncoder::encode(const std::vector<std::string>& texts) {
  const auto& outputs = network_.outputs();
  const auto named = std::find_if(outputs.begin(), outputs.end(),
                                  [](const auto& port) { return port.name == "last_hidden_state"; });
  const auto output = static_cast<std::size_t>(named == outputs.end() ? 0 : named - outputs.begin());
  std::vector<std::vector<float>> embeddings;
  for (std::size_t first = 0; first < texts.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, texts.size() - first);
    std::vector<std::vector<std::int64_t>> numbers;
    std::size_t longest = 0;
    for (std::size_t n = 0; n < count; ++n) {
      numbers.push_back(tokens_.numbersOf(texts[first + n]));
      longest = std::max(longest, numbers.back().size());
    }
    std::vector<std::int64_t> ids(count * longest, 0), mask(ids);
    for (std::size_t n = 0; n < count; ++n) {
      std::copy(numbers[n].begin(), numbers[n].end(), ids.begin() + static_cast<std::ptrdiff_t>(n * longest));
      std::fill_n(mask.begin() + static_cast<std::ptrdiff_t>(n * longest), numbers[n].size(), 1);
    }
    const std::vector<std::int64_t> shape{static_cast<std::int64_t>(count),
                                          static_cast<std::int64_t>(longest)};
    std::vector<NetworkTensor> inputs;
    for (const NetworkPort& port : network_.inputs())
      inputs.push_back({shape, port.name == "input_ids"        ? ids
                               : port.name == "attention_mask" ? mask
                                                               : std::vector<std::int64_t>(ids.size(), 0)});
    const NetworkTensor hidden = [&] {
      const std::lock_guard lock(mutex_);
      return network_.run(inputs, output);
    }();
    if (hidden.shape.size() != 3 || hidden.shape[0] != shape[0] || hidden.shape[1] != shape[1] ||
        hidden.shape[2] < 1)
      throw Error(ErrorCode::InvalidArgument,
                  network_.name() + " gives no vector for every piece of a text: give a sentence embedding "
                                    "such as all-MiniLM-L6-v2.");
    const auto& values = std::get<std::vector<float>>(hidden.values);
    const auto size = static_cast<std::size_t>(hidden.shape[2]);
    for (std::size_t n = 0; n < count; ++n) {
      std::vector<float> mean(size, 0.f);
      for (std::size_t piece = 0; piece < numbers[n].size(); ++piece)
        for (std::size_t c = 0; c < size; ++c)
          mean[c] += values[(n * longest + piece) * size + c];
      double square = 0;
      for (const float value : mean)
        square += static_cast<double>(value) * static_cast<double>(value);
      const double scale = square > 0 ? 1 / std::sqrt(square) : 0;
      for (float& value : mean)
        value = static_cast<float>(static_cast<double>(value) * scale);
      embeddings.push_back(std::move(mean));
    }
  }
  return embeddings;
}

namespace {

struct Chosen {
  std::mutex mutex;
  fs::path folder, loadedFrom;
  std::shared_ptr<SentenceEmbedding> loaded;
};

Chosen& chosen() {
  static Chosen one;
  return one;
}

} // namespace

SentenceModel sentenceModel() {
  Chosen& c = chosen();
  const std::lock_guard lock(c.mutex);
  fs::path folder = c.folder;
  if (const char* given = std::getenv("INNERGS_TEXT_MODEL"); folder.empty() && given) folder = given;
  if (folder.empty())
    return {nullptr, "Words beyond the lexicon need a sentence embedding: name a folder with model.onnx and "
                     "vocab.txt of all-MiniLM-L6-v2 in INNERGS_TEXT_MODEL."};
  if (c.loaded && c.loadedFrom == folder) return {c.loaded, {}};
  c.loaded.reset();
  try {
    c.loaded = std::make_shared<SentenceEncoder>(folder);
    c.loadedFrom = folder;
    return {c.loaded, {}};
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }
}

void setSentenceFolder(const fs::path& folder) {
  Chosen& c = chosen();
  const std::lock_guard lock(c.mutex);
  c.folder = folder;
}

} // namespace innergs
