#include "Text/PhraseReport.h"
#include "Core/Base/Error.h"
#include "Text/Terminology.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

TEST(PhraseReport, UnseenPhrasesMeetTheTargets) {
  const Lexicon& lexicon = Lexicon::standard();
  for (const auto json : {terminology::phrasesToTune(), terminology::phrasesToReport()}) {
    const PhraseSet set = phrasesFrom(lexicon, json);
    EXPECT_EQ(set.scene.size(), 117u);
    EXPECT_GE(set.phrases.size(), 80u);
    const PhraseReport r = reportOn(lexicon, set);
    EXPECT_GE(r.top1, 0.75 * r.named);
    EXPECT_LE(r.wrong, 0.02 * r.named);
    EXPECT_LE(r.falseAccepts, 0.05 * r.foreign);
    EXPECT_EQ(r.flipped, 0);
  }
}

TEST(PhraseReport, CountsWhatGoesWrong) {
  const PhraseSet set = phrasesFrom(Lexicon::standard(), R"({"absent": [], "phrases": [
    {"text": "left kidney", "kind": "x", "expect": ["kidney_right"]},
    {"text": "liver", "kind": "x", "expect": []},
    {"text": "spleen", "kind": "x", "expect": ["spleen"]},
    {"text": "pelvic floor", "kind": "x", "expect": ["hip_*"]}]})");
  const PhraseReport r = reportOn(Lexicon::standard(), set);
  EXPECT_EQ(r.named, 3);
  EXPECT_EQ(r.foreign, 1);
  EXPECT_EQ(r.top1, 1);
  EXPECT_EQ(r.wrong, 1);
  EXPECT_EQ(r.flipped, 1);
  EXPECT_EQ(r.falseAccepts, 1);
  EXPECT_EQ(r.misses.size(), 3u);
  EXPECT_THROW(phrasesFrom(Lexicon::standard(), "[]"), Error);
}

} // namespace
} // namespace innergs
