#include "Text/Query.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

#include <set>

namespace innergs {
namespace {

std::vector<std::string> namesOf(const std::string& text) {
  const Lexicon& lexicon = Lexicon::standard();
  const auto read = interpret(lexicon, text);
  std::vector<std::string> names;
  if (!read.empty())
    for (const Structure& structure : read[0].structures)
      names.push_back(lexicon.nameOf(structure));
  return names;
}
using Names = std::vector<std::string>;

TEST(Query, ReadsSideAndNumberApart) {
  EXPECT_EQ(namesOf("seventh rib on the left"), Names{"rib_left_7"});
  EXPECT_EQ(namesOf("rib 7"), (Names{"rib_left_7", "rib_right_7"}));
  EXPECT_EQ(namesOf("third lumbar vertebra"), Names{"vertebrae_L3"});
  EXPECT_EQ(namesOf("vertebra 3").size(), 3u); // C3, T3, L3: the region is not given
  EXPECT_EQ(namesOf("costa septima dextra"), Names{"rib_right_7"});
  EXPECT_EQ(namesOf("left lower lobe of the lung"), Names{"lung_lower_lobe_left"});
  EXPECT_EQ(namesOf("left middle lobe"), Names{}); // does not exist
  EXPECT_EQ(namesOf("L6"), Names{});
  EXPECT_EQ(namesOf("rib 13"), Names{});
}

TEST(Query, EveryWordMustCount) {
  for (const char* text : {"liver mass", "T2 weighted liver", "liver segment 4", "left liver", "renal artery",
                           "not the liver", "left", "7", "the", "bicycle", "liver and spleen"})
    EXPECT_EQ(namesOf(text), Names{}) << text;
  EXPECT_EQ(namesOf("please segment the liver"), Names{"liver"});
}

TEST(Query, EveryNameOfTheLexiconMeansItself) {
  const Lexicon& lexicon = Lexicon::standard();
  std::set<std::string> seen;
  for (const Concept& c : lexicon.concepts())
    for (const Structure& structure : c.structures) {
      const std::string name = lexicon.nameOf(structure);
      EXPECT_EQ(namesOf(name), Names{name});
      EXPECT_FALSE(lexicon.codeOf(structure).empty()) << name;
      seen.insert(name);
    }
  EXPECT_GE(seen.size(), 117u);
}

/// All texts with one typing error.
std::vector<std::string> misspelt(const std::string& text) {
  std::vector<std::string> all;
  for (std::size_t n = 0; n < text.size(); ++n) {
    std::string other = text;
    all.push_back(other.erase(n, 1));
    other = text;
    if (n + 1 < text.size()) std::swap(other[n], other[n + 1]);
    all.push_back(other);
    for (const char letter : std::string("aeilrtsn")) {
      other = text;
      other[n] = letter;
      all.push_back(other);
      other = text;
      all.push_back(other.insert(n, 1, letter));
    }
  }
  return all;
}

TEST(Query, NoTypingErrorTurnsASide) {
  const Lexicon& lexicon = Lexicon::standard();
  for (const auto& [text, side] : {std::pair{"left kidney", Side::Left},
                                   {"right kidney", Side::Right},
                                   {"linke Niere", Side::Left},
                                   {"rein droit", Side::Right},
                                   {"femur sinister", Side::Left},
                                   {"left 7th rib", Side::Left}})
    for (const std::string& typed : misspelt(text))
      for (const Interpretation& reading : interpret(lexicon, typed)) {
        bool asked = false;
        for (const Structure& structure : reading.structures)
          asked = asked || structure.side == side || structure.side == Side::None;
        EXPECT_TRUE(asked) << typed;
      }
}

TEST(Query, RefusesWhatIsNoQuery) {
  const Lexicon& lexicon = Lexicon::standard();
  for (const std::string& text : {std::string(), std::string(" ?! "), std::string(2000, 'a')})
    EXPECT_EQ(test::codeOf([&] { interpret(lexicon, text); }), ErrorCode::InvalidArgument) << text.size();
}

TEST(Query, DamagedLexiconIsOneSentence) {
  EXPECT_THROW(Lexicon("{}", "{}"), Error);
  EXPECT_THROW(Lexicon(R"({"format": "InnerGS terminology", "version": 1, "concepts": [{"id": 5}]})", "{}"),
               Error);
}

} // namespace
} // namespace innergs
