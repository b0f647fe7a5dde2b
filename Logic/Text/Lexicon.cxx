#include "Text/Lexicon.h"

#include "Core/Base/Error.h"
#include "Text/Terminology.h"
#include "Text/Words.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace innergs {
namespace {

using nlohmann::json;

json parsed(std::string_view text, const std::string& format) {
  json value = json::parse(text, nullptr, false);
  if (!value.is_object() || value.value("format", "") != format || value.value("version", 0) != 1)
    throw Error(ErrorCode::FileFormat, "The lexicon is not a file of the format '" + format +
                                           "', version 1; install InnerGS's own again.");
  return value;
}

std::vector<Side> sidesOf(const json& entry) {
  if (entry.value("paired", false)) return {Side::Left, Side::Right};
  if (!entry.contains("sides")) return {Side::None};
  std::vector<Side> sides;
  for (const std::string side : entry["sides"])
    sides.push_back(side == "left" ? Side::Left : Side::Right);
  return sides;
}

Concept conceptOf(const json& entry) {
  Concept c;
  c.id = entry.at("id");
  c.code = entry.value("code", "");
  c.meaning = entry.value("meaning", "");
  c.kind = entry.at("kind");
  c.name = entry.at("name");
  c.sides = sidesOf(entry);
  c.numbers = entry.value("numbers", 0);
  c.codes = entry.value("codes", std::vector<std::string>{});
  c.letters = entry.value("letters", std::vector<std::string>{});
  c.named = entry.value("named", std::map<std::string, int>{});
  for (const std::string term : entry.at("terms"))
    c.terms.push_back(wordsOf(term));
  if (c.numbers > 0 && static_cast<int>(c.codes.size()) != c.numbers)
    throw Error(ErrorCode::FileFormat,
                "The lexicon's entry '" + c.id + "' does not have one code per number.");
  return c;
}

/// The meanings of a concept; for a group, those of its parts, without sides that its parts do not have.
Structures structuresOf(const std::vector<Concept>& concepts, const json& entries, std::size_t index) {
  const Concept& c = concepts[index];
  Structures all;
  if (!entries[index].contains("parts")) {
    for (const Side side : c.sides)
      for (int number = c.numbers > 0; number <= c.numbers; ++number)
        all.push_back({static_cast<int>(index), side, number});
  } else {
    for (const std::string part : entries[index]["parts"]) {
      const auto found =
          std::find_if(concepts.begin(), concepts.end(), [&](const Concept& o) { return o.id == part; });
      const auto at = static_cast<std::size_t>(found - concepts.begin());
      if (found == concepts.end() || at == index)
        throw Error(ErrorCode::FileFormat, "The lexicon's entry '" + c.id + "' has a part without an entry.");
      const Structures own = structuresOf(concepts, entries, at);
      all.insert(all.end(), own.begin(), own.end());
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

} // namespace

Lexicon::Lexicon(std::string_view anatomy, std::string_view words) {
  try {
    const json entries = parsed(anatomy, "InnerGS terminology").at("concepts");
    for (const json& entry : entries)
      concepts_.push_back(conceptOf(entry));
    for (std::size_t n = 0; n < concepts_.size(); ++n)
      concepts_[n].structures = structuresOf(concepts_, entries, n);
    const json w = parsed(words, "InnerGS query words");
    const auto role = [&](const char* key, Role meaning) {
      for (const std::string word : w.at(key))
        roles_[word].push_back(meaning);
    };
    role("left", Role::Left);
    role("right", Role::Right);
    role("both", Role::Both);
    role("filler", Role::Filler);
    role("verbs", Role::Verb);
    role("ordinary", Role::Ordinary);
    left_ = w.at("left").get<std::vector<std::string>>();
    right_ = w.at("right").get<std::vector<std::string>>();
    ordinals_ = w.at("ordinals").get<std::map<std::string, int>>();
    kinds_ = w.at("kinds").get<std::map<std::string, std::vector<std::string>>>();
  } catch (const json::exception& error) {
    throw Error(ErrorCode::FileFormat, std::string("The lexicon is damaged: ") + error.what());
  }
}

const Lexicon& Lexicon::standard() {
  static const Lexicon lexicon(terminology::anatomy(), terminology::words());
  return lexicon;
}

std::string Lexicon::nameOf(const Structure& structure) const {
  std::string name = concepts_.at(structure.kind).name;
  const auto fill = [&](const std::string& place, const std::string& value) {
    if (const auto at = name.find(place); at != std::string::npos) name.replace(at, place.size(), value);
  };
  fill("{side}", structure.side == Side::Left ? "left" : "right");
  fill("{number}", std::to_string(structure.number));
  return name;
}

std::string Lexicon::codeOf(const Structure& structure) const {
  const Concept& c = concepts_.at(structure.kind);
  return structure.number > 0 ? c.codes[structure.number - 1] : c.code;
}

std::string Lexicon::meaningOf(const Structure& structure) const {
  const Concept& c = concepts_.at(structure.kind);
  if (structure.number == 0) return c.meaning;
  if (c.letters.empty()) return c.meaning + " " + std::to_string(structure.number);
  return std::string(1, static_cast<char>(c.letters[0][0] - 'a' + 'A')) + std::to_string(structure.number) +
         " vertebra";
}

bool Lexicon::is(const std::string& word, Role role) const {
  const auto found = roles_.find(word);
  return found != roles_.end() && std::count(found->second.begin(), found->second.end(), role) > 0;
}

bool Lexicon::isKindWord(const std::string& word, const std::string& kind) const {
  const auto found = kinds_.find(kind);
  return found != kinds_.end() && std::count(found->second.begin(), found->second.end(), word) > 0;
}

bool Lexicon::isKindWord(const std::string& word) const {
  return std::any_of(kinds_.begin(), kinds_.end(), [&](const auto& kind) {
    return std::count(kind.second.begin(), kind.second.end(), word) > 0;
  });
}

} // namespace innergs
