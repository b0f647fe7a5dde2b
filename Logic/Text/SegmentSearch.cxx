#include "Text/SegmentSearch.h"

#include "Core/Base/Error.h"
#include "Text/SimilarSegments.h"
#include "Text/Words.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr double kWider = 0.6; // factor on the score of a segment that contains more than requested

bool within(const Structures& inner, const Structures& outer) {
  return std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

/// "kidney" means one of two, "kidneys" both.
bool isOpen(const Lexicon& lexicon, const Structures& structures, const std::vector<std::string>& words) {
  if (structures.size() < 2) return false;
  const int kind = structures[0].kind;
  if (std::any_of(structures.begin(), structures.end(), [&](const auto& s) { return s.kind != kind; }))
    return false; // a group, such as the bowel
  return std::none_of(words.begin(), words.end(), [&](const std::string& word) {
    return singular(word) != word || lexicon.is(word, Lexicon::Role::Both) || word == "all";
  });
}

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t n = 0; n < names.size() && n < most; ++n)
    text += (n ? ", " : "") + names[n];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

} // namespace

SegmentSearch::SegmentSearch(const Lexicon& lexicon, std::vector<NamedSegment> segments,
                             std::function<SentenceModel()> sentences)
    : lexicon_(lexicon), segments_(std::move(segments)), sentences_(std::move(sentences)) {
  for (std::size_t n = 0; n < segments_.size(); ++n) {
    Entry entry{wordsOf(segments_[n].name), {}};
    if (entry.words.empty())
      throw Error(ErrorCode::InvalidArgument,
                  "Segment " + std::to_string(n + 1) + " has no name; name it, e.g. \"liver\".");
    if (segments_[n].name.size() <= 300) {
      const auto read = interpret(lexicon_, segments_[n].name);
      if (!read.empty() && read[0].score == 1) entry.structures = read[0].structures;
    }
    entries_.push_back(std::move(entry));
  }
}

SegmentSearch::~SegmentSearch() = default;
SegmentSearch::SegmentSearch(SegmentSearch&&) noexcept = default;

/// Turns NoMatch into Similar where a sentence embedding knows segments of nearly that meaning.
void SegmentSearch::addSimilar(std::string_view query, SegmentAnswer& answer) const {
  if (!sentences_) return;
  SentenceModel model = sentences_();
  answer.note = model.problem;
  if (!model.embedding) return;
  try {
    if (!similar_ || embedding_ != model.embedding) {
      std::vector<Structures> structures;
      for (const Entry& entry : entries_)
        structures.push_back(entry.structures);
      similar_ = std::make_unique<SimilarSegments>(lexicon_, segments_, structures, *model.embedding);
      embedding_ = model.embedding;
    }
    answer.candidates = similar_->find(query, *embedding_);
  } catch (const Error& error) { // a network of another kind
    answer.note = error.what();
  }
  if (!answer.candidates.empty()) answer.kind = AnswerKind::Similar;
}

std::vector<SegmentCandidate> SegmentSearch::byName(const std::vector<std::string>& words) const {
  std::vector<std::string> bare;
  for (const std::string& word : words)
    if (!lexicon_.is(word, Lexicon::Role::Filler)) bare.push_back(word);
  std::vector<SegmentCandidate> found;
  for (std::size_t n = 0; n < entries_.size(); ++n)
    if (segments_[n].present && (entries_[n].words == words || entries_[n].words == bare))
      found.push_back({static_cast<int>(n), 1, false});
  return found;
}

SegmentAnswer SegmentSearch::find(std::string_view query) const {
  const std::vector<Interpretation> readings = interpret(lexicon_, query);
  const std::vector<std::string> words = wordsOf(query);
  SegmentAnswer answer;
  answer.candidates = byName(words);
  answer.leading = answer.candidates.size();
  if (answer.leading > 0) answer.kind = AnswerKind::Found;
  const auto known = [&](int segment) {
    return std::any_of(answer.candidates.begin(), answer.candidates.end(),
                       [&](const auto& c) { return c.segment == segment; });
  };
  for (const Interpretation& reading : readings) {
    std::vector<SegmentCandidate> parts, wider;
    for (std::size_t n = 0; n < entries_.size(); ++n) {
      const Structures& own = entries_[n].structures;
      const int segment = static_cast<int>(n);
      if (own.empty() || !segments_[n].present || known(segment)) continue;
      if (within(own, reading.structures))
        parts.push_back({segment, reading.score, false});
      else if (within(reading.structures, own))
        wider.push_back({segment, kWider * reading.score, true});
    }
    const bool first = answer.leading == 0 && &reading == &readings[0];
    if (first && !parts.empty()) {
      answer.leading = parts.size();
      answer.kind = parts.size() > 1 && isOpen(lexicon_, reading.structures, words) ? AnswerKind::Several
                                                                                    : AnswerKind::Found;
    } else if (first && !wider.empty()) {
      answer.leading = wider.size();
      answer.kind = AnswerKind::Wider;
    }
    answer.candidates.insert(answer.candidates.end(), parts.begin(), parts.end());
    answer.candidates.insert(answer.candidates.end(), wider.begin(), wider.end());
  }
  if (!readings.empty())
    for (const Structure& structure : readings[0].structures)
      answer.structures.push_back(lexicon_.nameOf(structure));
  if (answer.kind == AnswerKind::NoMatch && !readings.empty()) answer.kind = AnswerKind::NotInVolume;
  if (answer.kind == AnswerKind::NoMatch) addSimilar(query, answer);
  std::stable_sort(answer.candidates.begin() + static_cast<std::ptrdiff_t>(answer.leading),
                   answer.candidates.end(), [](const auto& a, const auto& b) { return a.score > b.score; });

  std::vector<std::string> names;
  const std::size_t told = answer.kind == AnswerKind::Similar ? answer.candidates.size() : answer.leading;
  for (std::size_t n = 0; n < told; ++n)
    names.push_back(segments_[answer.candidates[n].segment].name);
  const std::string asked = "\"" + std::string(query) + "\"";
  switch (answer.kind) {
  case AnswerKind::Found:
    answer.sentence = asked + " is " + joined(names) + ".";
    break;
  case AnswerKind::Several:
    answer.sentence = asked + " can be " + joined(names) + "; say which, e.g. its side or number.";
    break;
  case AnswerKind::Wider:
    answer.sentence = asked + " is not a separate segment here; " + joined(names) + " contains it and more.";
    break;
  case AnswerKind::NotInVolume:
    answer.sentence = asked + " (" + joined(answer.structures) + ") is not in this volume.";
    break;
  case AnswerKind::NoMatch:
    answer.sentence =
        asked + " matches no segment; use a structure's name, e.g. \"liver\" or \"left kidney\".";
    break;
  case AnswerKind::Similar:
    answer.sentence =
        asked + " is not a known name; nearest in meaning: " + joined(names) + "; ask for one of them.";
    break;
  }
  return answer;
}

} // namespace innergs
