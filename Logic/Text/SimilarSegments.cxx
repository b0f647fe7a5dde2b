#include "Text/SimilarSegments.h"

#include "Text/Words.h"

#include <algorithm>
#include <map>

namespace innergs {
namespace {

constexpr std::size_t kTerms = 3; // of a structure, so that a scene of a hundred is encoded in a second

double cosine(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
    sum += static_cast<double>(a[n]) * static_cast<double>(b[n]);
  return sum;
}

} // namespace

SimilarSegments::SimilarSegments(const Lexicon& lexicon, const std::vector<NamedSegment>& segments,
                                 const std::vector<Structures>& structures, SentenceEmbedding& embedding)
    : lexicon_(lexicon) {
  std::map<std::string, std::size_t> numberOf;
  std::vector<std::string> texts;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    if (!segments[n].present) continue;
    Entry entry{static_cast<int>(n), Side::None, {}};
    std::vector<std::string> phrases{withoutSide(wordsOf(segments[n].name))};
    const Structures& own = structures[n];
    if (!own.empty()) {
      entry.side = own[0].side;
      for (const Structure& structure : own)
        if (structure.side != entry.side) entry.side = Side::None; // both
      const Concept& c = lexicon.concepts()[static_cast<std::size_t>(own[0].kind)];
      for (std::size_t term = 0; term < std::min(kTerms, c.terms.size()); ++term)
        phrases.push_back(withoutSide(c.terms[term]));
    }
    for (const std::string& phrase : phrases) {
      if (phrase.empty()) continue;
      const auto [at, isNew] = numberOf.emplace(phrase, texts.size());
      if (isNew) texts.push_back(phrase);
      entry.phrases.push_back(at->second);
    }
    entries_.push_back(std::move(entry));
  }
  meanings_ = embedding.encode(texts);
}

std::string SimilarSegments::withoutSide(const std::vector<std::string>& words) const {
  std::string text;
  for (const std::string& word : words)
    if (!lexicon_.is(word, Lexicon::Role::Left) && !lexicon_.is(word, Lexicon::Role::Right))
      text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<SegmentCandidate> SimilarSegments::find(std::string_view query,
                                                    SentenceEmbedding& embedding) const {
  const std::vector<std::string> words = wordsOf(query);
  const auto has = [&](Lexicon::Role role) {
    return std::any_of(words.begin(), words.end(), [&](const auto& word) { return lexicon_.is(word, role); });
  };
  const bool left = has(Lexicon::Role::Left), right = has(Lexicon::Role::Right);
  const std::string meaning = withoutSide(words);
  std::vector<SegmentCandidate> found;
  if (meaning.empty()) return found;
  const std::vector<float> asked = embedding.encode({meaning}).at(0);
  for (const Entry& entry : entries_) {
    if (left != right && entry.side == (left ? Side::Right : Side::Left)) continue;
    double best = -1;
    for (const std::size_t phrase : entry.phrases)
      best = std::max(best, cosine(asked, meanings_[phrase]));
    if (best >= kLeastCosine) found.push_back({entry.segment, std::min(best, 1.0), false});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  if (found.size() > kMost) found.resize(kMost);
  return found;
}

} // namespace innergs
