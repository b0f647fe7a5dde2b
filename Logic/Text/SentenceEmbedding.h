#pragma once
#include <memory>
#include <string>
#include <vector>

namespace innergs {

/// What texts mean, as unit vectors whose cosine says how near two meanings are.
class SentenceEmbedding {
public:
  virtual ~SentenceEmbedding() = default;
  /// A vector per text. Any thread.
  virtual std::vector<std::vector<float>> encode(const std::vector<std::string>& texts) = 0;
};

struct SentenceModel {
  std::shared_ptr<SentenceEmbedding> embedding; // null: there is none
  std::string problem;                          // one sentence on what is missing where; "": nothing
};

} // namespace innergs
