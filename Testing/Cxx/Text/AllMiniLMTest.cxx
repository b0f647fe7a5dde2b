#include "Onnx/OpenVino.h"
#include "Text/PhraseReport.h"
#include "Text/SegmentSearch.h"
#include "Text/SentenceEncoder.h"
#include "Text/Terminology.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>

namespace innergs {
namespace {

/// Of all-MiniLM-L6-v2 itself, in the folder that INNERGS_TEXT_MODEL names.
class AllMiniLM : public ::testing::Test {
protected:
  void SetUp() override {
    if (!std::getenv("INNERGS_TEXT_MODEL"))
      GTEST_SKIP() << "INNERGS_TEXT_MODEL names no folder with all-MiniLM-L6-v2.";
    if (!openVino().functions) GTEST_SKIP() << openVino().problem;
    const SentenceModel model = sentenceModel();
    embedding = model.embedding;
    ASSERT_NE(embedding, nullptr) << model.problem;
  }
  std::shared_ptr<SentenceEmbedding> embedding;
};

/// By the tokenizer.json of its authors.
TEST_F(AllMiniLM, TokensAreTheReferences) {
  const WordPiece pieces(std::filesystem::path(std::getenv("INNERGS_TEXT_MODEL")) / "vocab.txt");
  using Numbers = std::vector<std::int64_t>;
  EXPECT_EQ(pieces.numbersOf("Left kidney"), (Numbers{101, 2187, 14234, 102}));
  EXPECT_EQ(pieces.numbersOf("L'\xc5\x93sophage \xc3\xa0 gauche"),
            (Numbers{101, 1048, 1005, 1107, 28793, 3270, 3351, 1037, 11721, 19140, 102}));
  EXPECT_EQ(
      pieces.numbersOf("T2-weighted, 12th rib (3.5 mm)"),
      (Numbers{101, 1056, 2475, 1011, 18215, 1010, 5940, 19395, 1006, 1017, 1012, 1019, 3461, 1007, 102}));
  EXPECT_EQ(pieces.numbersOf("splin\xc4\x83 \xc8\x99i ficat"),
            (Numbers{101, 11867, 13786, 9033, 10882, 11266, 102}));
}

/// The network with its single-precision weights, in double precision; 8-bit weights move a cosine by up to
/// 0.02.
TEST_F(AllMiniLM, CosinesAreTheReferences) {
  struct Pair {
    const char *a, *b;
    double cosine;
  };
  for (const Pair& pair : {Pair{"heart", "blood pump", 0.4393},
                           {"kidney", "kidneys", 0.8868},
                           {"liver", "hepatic tumour", 0.5819},
                           {"liver", "bicycle", 0.3145},
                           {"the organ that stores bile", "gallbladder", 0.5573},
                           {"spine", "vertebra", 0.7633}}) {
    const auto both = embedding->encode({pair.a, pair.b});
    EXPECT_NEAR(std::inner_product(both[0].begin(), both[0].end(), both[1].begin(), 0.0), pair.cosine, 0.03)
        << pair.a << ", " << pair.b;
  }
}

TEST_F(AllMiniLM, SuggestsWhatTheLexiconMissesAndAnswersNothingElse) {
  const Lexicon& lexicon = Lexicon::standard();
  int unanswered = 0, suggested = 0;
  for (const auto json : {terminology::phrasesToTune(), terminology::phrasesToReport()}) {
    const PhraseSet set = phrasesFrom(lexicon, json);
    const PhraseReport without = reportOn(lexicon, set), with = reportOn(lexicon, set, embedding);
    EXPECT_EQ(with.top1, without.top1);
    EXPECT_EQ(with.wrong, without.wrong);
    EXPECT_EQ(with.flipped, 0);
    EXPECT_EQ(with.falseAccepts, without.falseAccepts);
    EXPECT_GE(with.top3, without.top3);
    EXPECT_EQ(with.top3, without.top3 + with.suggested);
    unanswered += with.unanswered;
    suggested += with.suggested;
  }
  EXPECT_GE(suggested, 0.75 * unanswered);
  const SegmentSearch search(lexicon, {{"heart", true}, {"liver", true}}, sentenceModel);
  for (const char* foreign : {"unicorn", "telephone number", "colour"}) // below the least cosine
    EXPECT_EQ(search.find(foreign).kind, AnswerKind::NoMatch) << foreign;
}

} // namespace
} // namespace innergs
