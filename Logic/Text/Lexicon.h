#pragma once
#include <compare>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace innergs {

enum class Side { None, Left, Right };

/// One anatomical structure that a segment can be: a concept of the lexicon without parts, with its side and
/// its number (ribs, vertebrae; 0: none).
struct Structure {
  int kind = 0; // index into Lexicon::concepts()
  Side side = Side::None;
  int number = 0;
  auto operator<=>(const Structure&) const = default;
};
using Structures = std::vector<Structure>; // ascending, each once

/// A kind of structure, as listed in Resources/Terminology/anatomy.json.
struct Concept {
  std::string id, code, meaning;               // SNOMED CT code and its meaning
  std::string kind;                            // "bone", "muscle", …: kind words allowed with its name
  std::string name;                            // of a segment; {side} and {number} are placeholders
  std::vector<Side> sides;                     // {None} if it is not paired
  int numbers = 0;                             // 1…numbers; 0: not numbered
  std::vector<std::string> codes;              // one per number
  std::vector<std::string> letters;            // "l" of L3
  std::map<std::string, int> named;            // "atlas": 1
  std::vector<std::vector<std::string>> terms; // as words
  Structures structures; // all possible meanings: those of its parts, or its own sides and numbers
};

/// Names of anatomical structures in several languages, and the words around them. Immutable after
/// construction, so threads may share it.
class Lexicon {
public:
  /// Reads the texts of the two files of Resources/Terminology. Throws Error(FileFormat).
  Lexicon(std::string_view anatomy, std::string_view words);
  /// The built-in lexicon.
  static const Lexicon& standard();

  const std::vector<Concept>& concepts() const { return concepts_; }
  /// "kidney_left", "rib_right_7"
  std::string nameOf(const Structure& structure) const;
  /// SNOMED CT code of the structure without its side, and the code's meaning.
  std::string codeOf(const Structure& structure) const;
  std::string meaningOf(const Structure& structure) const;

  /// The roles of words beside names in a query. A word can have several.
  enum class Role { Left, Right, Both, Filler, Verb, Ordinary };
  bool is(const std::string& word, Role role) const;
  /// Whether a word such as "bone" or "muscle" matches a kind of concept.
  bool isKindWord(const std::string& word, const std::string& kind) const;
  bool isKindWord(const std::string& word) const;
  const std::map<std::string, int>& ordinals() const { return ordinals_; }
  const std::vector<std::string>& sideWords(Side side) const { return side == Side::Left ? left_ : right_; }

private:
  std::vector<Concept> concepts_;
  std::map<std::string, std::vector<Role>> roles_;
  std::map<std::string, std::vector<std::string>> kinds_;
  std::map<std::string, int> ordinals_;
  std::vector<std::string> left_, right_;
};

} // namespace innergs
