#include "Text/Words.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

using Words = std::vector<std::string>;

TEST(Words, AreLowerCaseWithoutAccentsAndPunctuation) {
  EXPECT_EQ(wordsOf("Vertebrae_L3"), (Words{"vertebrae", "l3"}));
  EXPECT_EQ(wordsOf("  the patient's LEFT  kidney? "), (Words{"the", "patients", "left", "kidney"}));
  EXPECT_EQ(wordsOf("Bauchspeicheldr\xC3\xBCse"), Words{"bauchspeicheldruse"});
  EXPECT_EQ(wordsOf("ri\xC3\xB1\xC3\xB3n"), Words{"rinon"});
  EXPECT_EQ(wordsOf("rin\xCC\x83on"), Words{"rinon"});                        // decomposed
  EXPECT_EQ(wordsOf("\xC8\x99old ph\xE1\xBB\x95i"), (Words{"sold", "phoi"})); // Romanian, Vietnamese
  EXPECT_EQ(wordsOf("l'aorte"), Words{"aorte"});
  EXPECT_EQ(wordsOf("LeftKidney"), (Words{"left", "kidney"}));
  EXPECT_EQ(wordsOf("\xFF\xC3 ?!"), Words{}); // not UTF-8
}

TEST(Words, SingularLeavesLatinEndings) {
  EXPECT_EQ(singular("kidneys"), "kidney");
  EXPECT_EQ(singular("arteries"), "artery");
  for (const char* word : {"pancreas", "humerus", "pelvis", "ribbon", "os"})
    EXPECT_EQ(singular(word), word);
}

TEST(Words, EditDistanceCountsSwapsOnce) {
  EXPECT_EQ(editDistance("kindey", "kidney", 2), 1);
  EXPECT_EQ(editDistance("livr", "liver", 2), 1);
  EXPECT_EQ(editDistance("spleen", "spleen", 2), 0);
  EXPECT_EQ(editDistance("left", "right", 2), 3); // more than allowed
}

} // namespace
} // namespace innergs
