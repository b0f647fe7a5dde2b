#pragma once
#include "Onnx/OnnxNetwork.h"
#include "Text/SentenceEmbedding.h"
#include "Text/WordPiece.h"

#include <mutex>

namespace innergs {

/// A sentence embedding by a BERT-like network such as all-MiniLM-L6-v2: a folder with its vocab.txt and
/// model.onnx (or onnx/model.onnx) of the inputs input_ids, attention_mask and perhaps token_type_ids. The
/// meaning of a text is the mean of the network's last_hidden_state over its pieces, at unit length (Reimers
/// & Gurevych 2019).
class SentenceEncoder final : public SentenceEmbedding {
public:
  /// Throws Error(FileNotFound | FileFormat | NoData), with a sentence on what is missing where.
  explicit SentenceEncoder(const std::filesystem::path& folder);

  /// Throws Error(InvalidArgument | UnsupportedImage) where the network is of another kind.
  std::vector<std::vector<float>> encode(const std::vector<std::string>& texts) override;

private:
  WordPiece tokens_;
  OnnxNetwork network_;
  std::mutex mutex_; // of the network's one stream
};

/// The sentence embedding that queries use: from the folder of setSentenceFolder() or, where none is set, of
/// INNERGS_TEXT_MODEL. Loads it at the first call for a folder; after a failure, again at every call. Never
/// throws. Any thread.
SentenceModel sentenceModel();
/// "": the environment variable's.
void setSentenceFolder(const std::filesystem::path& folder);

} // namespace innergs
