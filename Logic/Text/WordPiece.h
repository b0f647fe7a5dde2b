#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace innergs {

/// Turns texts into the numbers of BERT's uncased vocabularies: lower case without accents (of Latin; Greek
/// and Cyrillic in lower case), split at spaces and punctuation, then the longest pieces in the vocabulary
/// from the left (WordPiece, Wu et al. 2016; Devlin et al. 2019).
class WordPiece {
public:
  /// A vocab.txt: a piece per line, its number that of the line from 0. Throws Error(FileNotFound |
  /// FileFormat).
  explicit WordPiece(const std::filesystem::path& vocabulary);

  /// [CLS], the text's pieces, [SEP]; at most `longest` numbers.
  std::vector<std::int64_t> numbersOf(std::string_view text, std::size_t longest = 128) const;

private:
  std::int64_t numberOf(const std::string& piece) const; // −1: not in the vocabulary
  void addPieces(const std::string& word, std::vector<std::int64_t>& numbers) const;

  std::unordered_map<std::string, std::int64_t> pieces_;
  std::int64_t unknown_ = 0, first_ = 0, last_ = 0; // [UNK], [CLS], [SEP]
};

} // namespace innergs
