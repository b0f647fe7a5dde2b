#include "Text/Query.h"

#include "Core/Base/Error.h"
#include "Text/Words.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace innergs {
namespace {

constexpr std::size_t kLongestText = 300; // bytes
constexpr double kEdit = 0.12;            // cost of a typing error
constexpr int kStates = 20000;            // limit of partial readings; far more than any sentence needs

/// How many typing errors a word of the lexicon may have. Short words are too similar to each other.
int allowedEdits(std::size_t length) {
  return length < 5 ? 0 : length < 8 ? 1 : 2;
}

bool sameStart(const std::string& a, const std::string& b) {
  return a[0] == b[0] || (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0]);
}

/// Typing errors between a word of the query and one of a term; nothing if there are too many.
std::optional<int> wordCost(const Lexicon& lexicon, const std::string& word, const std::string& term) {
  if (word == term || singular(word) == term || singular(word) == singular(term)) return 0;
  const int allowed = std::min(allowedEdits(term.size()), allowedEdits(word.size() + 1));
  if (allowed == 0 || !sameStart(word, term) || lexicon.is(word, Lexicon::Role::Ordinary)) return {};
  const int edits = std::min(editDistance(word, term, allowed), editDistance(singular(word), term, allowed));
  return edits <= allowed ? std::optional(edits) : std::nullopt;
}

std::optional<int> numberOf(const std::string& word) {
  int value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc{}) return {};
  const std::string_view rest(end, static_cast<std::size_t>(word.data() + word.size() - end));
  for (const char* suffix : {"", "st", "nd", "rd", "th", "er", "e", "eme", "a", "te"})
    if (rest == suffix) return value;
  return {};
}

/// A possible role of a sequence of words.
struct Option {
  enum class Type { Mention, Side, Both, Number, Kind, Skip, Verb } type;
  int length = 1; // words
  int edits = 0;  // typing errors
  int kind = 0;   // Mention: the concept
  int number = 0; // for Number, and for a mention such as "L3"
  Side side = Side::None;
};

class Reader {
public:
  Reader(const Lexicon& lexicon, std::vector<std::string> words)
      : lexicon_(lexicon), words_(std::move(words)), options_(words_.size()) {
    for (std::size_t at = 0; at < words_.size(); ++at) {
      addOwnMeanings(at);
      addCodes(at);
    }
    for (std::size_t kind = 0; kind < lexicon_.concepts().size(); ++kind)
      for (const auto& term : lexicon_.concepts()[kind].terms)
        for (std::size_t at = 0; at < words_.size(); ++at)
          addTerm(at, static_cast<int>(kind), term);
  }

  std::vector<Interpretation> read() {
    readFrom(0, {});
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<Interpretation> each;
    for (const Interpretation& i : found_)
      if (std::none_of(each.begin(), each.end(), [&](const auto& o) { return o.structures == i.structures; }))
        each.push_back(i);
    return each;
  }

private:
  using Role = Lexicon::Role;

  bool isFixed(std::size_t at) const { // has another meaning, so it is not a misspelt name
    return std::any_of(options_[at].begin(), options_[at].end(), [](const Option& o) {
      return o.edits == 0 &&
             (o.type == Option::Type::Side || o.type == Option::Type::Both || o.type == Option::Type::Number);
    });
  }

  void addOwnMeanings(std::size_t at) {
    const std::string& word = words_[at];
    auto& options = options_[at];
    if (lexicon_.is(word, Role::Filler)) options.push_back({.type = Option::Type::Skip});
    if (lexicon_.is(word, Role::Verb)) options.push_back({.type = Option::Type::Verb});
    if (lexicon_.is(word, Role::Both)) options.push_back({.type = Option::Type::Both});
    if (lexicon_.isKindWord(word)) options.push_back({.type = Option::Type::Kind});
    if (const auto number = numberOf(word))
      options.push_back({.type = Option::Type::Number, .number = *number});
    addSide(at);
    addOrdinal(at);
  }

  void addSide(std::size_t at) {
    const std::string& word = words_[at];
    int best[2] = {9, 9};
    for (const Side side : {Side::Left, Side::Right})
      for (const std::string& known : lexicon_.sideWords(side)) {
        int& least = best[side == Side::Right];
        if (word == known) least = 0;
        if (known.size() < 4 || word.size() < 4 || !sameStart(word, known) ||
            lexicon_.is(word, Role::Ordinary))
          continue;
        if (editDistance(word, known, 1) <= 1) least = std::min(least, 1);
      }
    // A word equally near to both decides nothing.
    if (best[0] != best[1])
      options_[at].push_back({.type = Option::Type::Side,
                              .edits = std::min(best[0], best[1]),
                              .side = best[0] < best[1] ? Side::Left : Side::Right});
  }

  void addOrdinal(std::size_t at) {
    const std::string& word = words_[at];
    const auto& ordinals = lexicon_.ordinals();
    if (const auto exact = ordinals.find(word); exact != ordinals.end()) {
      options_[at].push_back({.type = Option::Type::Number, .number = exact->second});
      return;
    }
    if (word.size() < 5 || lexicon_.is(word, Role::Ordinary)) return;
    std::vector<int> near;
    for (const auto& [known, number] : ordinals)
      if (known.size() >= 5 && sameStart(word, known) && editDistance(word, known, 1) <= 1 &&
          std::find(near.begin(), near.end(), number) == near.end())
        near.push_back(number);
    if (near.size() == 1)
      options_[at].push_back({.type = Option::Type::Number, .edits = 1, .number = near[0]});
  }

  /// "L3", "Th11", "atlas"
  void addCodes(std::size_t at) {
    const std::string& word = words_[at];
    for (std::size_t kind = 0; kind < lexicon_.concepts().size(); ++kind) {
      const Concept& c = lexicon_.concepts()[kind];
      int number = 0;
      for (const std::string& letter : c.letters)
        if (word.starts_with(letter) && word.size() > letter.size() &&
            word.find_first_not_of("0123456789", letter.size()) == std::string::npos)
          number = numberOf(word.substr(letter.size())).value_or(0);
      if (const auto named = c.named.find(word); named != c.named.end()) number = named->second;
      if (number >= 1 && number <= c.numbers)
        options_[at].push_back(
            {.type = Option::Type::Mention, .kind = static_cast<int>(kind), .number = number});
    }
  }

  void addTerm(std::size_t at, int kind, const std::vector<std::string>& term) {
    const auto add = [&](std::size_t length, int edits) {
      options_[at].push_back(
          {.type = Option::Type::Mention, .length = static_cast<int>(length), .edits = edits, .kind = kind});
    };
    if (at + term.size() <= words_.size()) {
      int edits = 0;
      bool near = true;
      for (std::size_t n = 0; n < term.size() && near; ++n) {
        const auto cost = wordCost(lexicon_, words_[at + n], term[n]);
        near = cost && (*cost == 0 || !isFixed(at + n));
        edits += cost.value_or(0);
      }
      if (near) add(term.size(), edits);
    }
    // Written as one word or two: "gall bladder", "shoulderblade".
    const auto joined = [](auto first, auto last) {
      std::string all;
      for (; first != last; ++first)
        all += *first;
      return all;
    };
    const std::string whole = joined(term.begin(), term.end());
    for (const std::size_t length : {term.size() - 1, term.size() + 1}) {
      if (length < 1 || at + length > words_.size() || whole.size() < 7) continue;
      bool fixed = false;
      for (std::size_t n = 0; n < length; ++n)
        fixed = fixed || isFixed(at + n);
      const std::string words = joined(words_.begin() + at, words_.begin() + at + length);
      if (fixed || !sameStart(words, whole)) continue;
      const int edits = std::min(editDistance(words, whole, 1), editDistance(singular(words), whole, 1));
      if (edits <= 1) add(length, edits);
    }
  }

  struct State {
    std::vector<Option> mentions;
    std::vector<std::string> kindWords;
    bool left = false, right = false;
    std::optional<int> number;
    int edits = 0;
  };

  void readFrom(std::size_t at, const State& state) {
    if (++states_ > kStates) return;
    if (at == words_.size()) return finish(state);
    for (const Option& o : options_[at]) {
      State next = state;
      next.edits += o.edits;
      switch (o.type) {
      case Option::Type::Mention:
        next.mentions.push_back(o);
        break;
      case Option::Type::Side:
        (o.side == Side::Left ? next.left : next.right) = true;
        break;
      case Option::Type::Both:
        next.left = next.right = true;
        break;
      case Option::Type::Number:
        if (next.number) continue;
        next.number = o.number;
        break;
      case Option::Type::Kind:
        next.kindWords.push_back(words_[at]);
        break;
      case Option::Type::Verb: // "segment the liver", but not "liver segment"
        if (!state.mentions.empty()) continue;
        break;
      case Option::Type::Skip:
        break;
      }
      readFrom(at + static_cast<std::size_t>(o.length), next);
    }
  }

  Structures structuresOf(const Option& mention) const {
    Structures all = lexicon_.concepts()[mention.kind].structures;
    if (mention.number > 0)
      std::erase_if(all, [&](const Structure& s) { return s.number != mention.number; });
    return all;
  }

  void finish(const State& state) {
    if (state.mentions.empty()) return;
    // Several names must mean one thing, named more and less specifically: "lower lobe of the lung".
    const Option* closest = &state.mentions[0];
    Structures structures = structuresOf(*closest);
    for (const Option& mention : state.mentions) {
      Structures own = structuresOf(mention);
      if (own.size() < structures.size()) {
        std::swap(own, structures);
        closest = &mention;
      }
      if (!std::includes(own.begin(), own.end(), structures.begin(), structures.end())) return;
    }
    const Concept& c = lexicon_.concepts()[closest->kind];
    for (const std::string& word : state.kindWords)
      if (!lexicon_.isKindWord(word, c.kind)) return;
    if (state.number) {
      const bool numbered =
          std::all_of(structures.begin(), structures.end(), [](const auto& s) { return s.number > 0; });
      if (!numbered) return;
      std::erase_if(structures, [&](const Structure& s) { return s.number != *state.number; });
    }
    if (state.left || state.right) {
      std::erase_if(structures, [&](const Structure& s) {
        return s.side == Side::None || (s.side == Side::Left ? !state.left : !state.right);
      });
    }
    if (!structures.empty())
      found_.push_back({std::move(structures), std::max(0.1, 1 - kEdit * state.edits)});
  }

  const Lexicon& lexicon_;
  std::vector<std::string> words_;
  std::vector<std::vector<Option>> options_;
  std::vector<Interpretation> found_;
  int states_ = 0;
};

} // namespace

std::vector<Interpretation> interpret(const Lexicon& lexicon, std::string_view text) {
  if (text.size() > kLongestText)
    throw Error(ErrorCode::InvalidArgument, "The query is " + std::to_string(text.size()) +
                                                " bytes long; name one structure in at most " +
                                                std::to_string(kLongestText) + ".");
  std::vector<std::string> words = wordsOf(text);
  if (words.empty())
    throw Error(ErrorCode::InvalidArgument,
                "The query is empty; name a structure, e.g. \"liver\" or \"left kidney\".");
  return Reader(lexicon, std::move(words)).read();
}

} // namespace innergs
