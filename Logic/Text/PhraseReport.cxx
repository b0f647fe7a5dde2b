#include "Text/PhraseReport.h"

#include "Core/Base/Error.h"
#include "Core/Base/Median.h"
#include "Text/SegmentSearch.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <set>

namespace innergs {
namespace {

bool matches(std::string_view name, std::string_view pattern) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == '*')
    return matches(name, pattern.substr(1)) || (!name.empty() && matches(name.substr(1), pattern));
  return !name.empty() && name[0] == pattern[0] && matches(name.substr(1), pattern.substr(1));
}

std::vector<std::string> namesWithout(const Lexicon& lexicon, const std::set<std::string>& absent) {
  std::set<std::string> names;
  for (const Concept& c : lexicon.concepts())
    for (const Structure& structure : c.structures)
      if (!absent.contains(lexicon.concepts()[static_cast<std::size_t>(structure.kind)].id))
        names.insert(lexicon.nameOf(structure));
  return {names.begin(), names.end()};
}

std::string otherSide(std::string name) {
  for (const auto& [from, to] : {std::pair{"_left", "_right"}, {"_right", "_left"}})
    if (const auto at = name.find(from); at != std::string::npos)
      return name.replace(at, std::string_view(from).size(), to);
  return name;
}

double medianOf(std::vector<double> values) {
  return values.empty() ? 0 : median(std::move(values));
}

} // namespace

PhraseSet phrasesFrom(const Lexicon& lexicon, std::string_view text) {
  PhraseSet set;
  try {
    const auto file = nlohmann::json::parse(text);
    set.scene = namesWithout(lexicon, file.at("absent").get<std::set<std::string>>());
    for (const auto& entry : file.at("phrases")) {
      Phrase phrase{entry.at("text"), entry.at("kind"), {}};
      for (const std::string pattern : entry.at("expect")) {
        const std::size_t before = phrase.expect.size();
        std::copy_if(set.scene.begin(), set.scene.end(), std::back_inserter(phrase.expect),
                     [&](const std::string& name) { return matches(name, pattern); });
        if (phrase.expect.size() == before)
          throw Error(ErrorCode::FileFormat, "The phrase '" + phrase.text + "' expects '" + pattern +
                                                 "', which names no structure.");
      }
      std::sort(phrase.expect.begin(), phrase.expect.end());
      set.phrases.push_back(std::move(phrase));
    }
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::FileFormat, std::string("The phrases cannot be read: ") + error.what());
  }
  return set;
}

PhraseReport reportOn(const Lexicon& lexicon, const PhraseSet& set,
                      std::shared_ptr<SentenceEmbedding> embedding) {
  std::vector<NamedSegment> scene;
  for (const std::string& name : set.scene)
    scene.push_back({name, true});
  const SegmentSearch search(lexicon, scene, [&] { return SentenceModel{embedding, {}}; });
  PhraseReport report;
  std::vector<double> milliseconds, unread;
  for (const Phrase& phrase : set.phrases) {
    const auto start = std::chrono::steady_clock::now();
    const SegmentAnswer answer = search.find(phrase.text);
    milliseconds.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    if (answer.kind == AnswerKind::NoMatch || answer.kind == AnswerKind::Similar)
      unread.push_back(milliseconds.back());
    std::vector<std::string> given, first, suggested;
    for (std::size_t n = 0; n < answer.candidates.size(); ++n) {
      const std::string& name = scene[static_cast<std::size_t>(answer.candidates[n].segment)].name;
      if (n < answer.leading) given.push_back(name);
      if (n < std::max<std::size_t>(3, phrase.expect.size())) first.push_back(name);
    }
    if (answer.kind == AnswerKind::Similar) suggested = first; // best first
    std::sort(given.begin(), given.end());
    std::sort(first.begin(), first.end());
    const auto hasAny = [&](const std::vector<std::string>& wanted) {
      return std::any_of(given.begin(), given.end(), [&](const std::string& name) {
        return std::find(wanted.begin(), wanted.end(), name) != wanted.end();
      });
    };
    bool missed = false;
    if (phrase.expect.empty()) {
      ++report.foreign;
      missed = !given.empty();
      report.falseAccepts += missed;
      report.foreignSuggested += !suggested.empty();
    } else {
      ++report.named;
      missed = given != phrase.expect;
      report.top1 += !missed;
      const bool among =
          std::includes(first.begin(), first.end(), phrase.expect.begin(), phrase.expect.end());
      report.top3 += among;
      report.unanswered += given.empty();
      report.suggested += among && !suggested.empty();
      if (!given.empty() && !hasAny(phrase.expect)) {
        ++report.wrong;
        std::vector<std::string> others = phrase.expect;
        std::transform(others.begin(), others.end(), others.begin(), otherSide);
        report.flipped += hasAny(others);
      }
    }
    if (missed) {
      std::string line = phrase.text + ":";
      for (const std::string& name : given)
        line += " " + name;
      if (given.empty()) line += " nothing";
      for (std::size_t n = 0; n < suggested.size(); ++n)
        line += (n == 0 ? "; suggested: " : " ") + suggested[n];
      report.misses.push_back(line);
    }
  }
  report.milliseconds = medianOf(milliseconds);
  report.unread = medianOf(unread);
  if (!milliseconds.empty()) report.slowest = *std::max_element(milliseconds.begin(), milliseconds.end());
  return report;
}

} // namespace innergs
