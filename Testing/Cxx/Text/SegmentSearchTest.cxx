#include "Text/SegmentSearch.h"
#include "Core/Base/Error.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

SegmentSearch searchOf(const std::vector<std::string>& names) {
  std::vector<NamedSegment> scene;
  for (const std::string& name : names)
    scene.push_back({name, true});
  return {Lexicon::standard(), scene};
}

std::vector<int> leadingOf(const SegmentAnswer& answer) {
  std::vector<int> segments;
  for (std::size_t n = 0; n < answer.leading; ++n)
    segments.push_back(answer.candidates[n].segment);
  return segments;
}

TEST(SegmentSearch, UnresolvedSideGivesAllCandidates) {
  const SegmentSearch search = searchOf({"kidney_left", "Right kidney", "liver"});
  EXPECT_EQ(leadingOf(search.find("left kidney")), std::vector<int>{0});
  EXPECT_EQ(leadingOf(search.find("right kindey")), std::vector<int>{1});
  const SegmentAnswer open = search.find("kidney");
  EXPECT_EQ(open.kind, AnswerKind::Several);
  EXPECT_EQ(leadingOf(open), (std::vector<int>{0, 1}));
  EXPECT_EQ(search.find("both kidneys").kind, AnswerKind::Found);
}

TEST(SegmentSearch, TellsAbsentFromUnknown) {
  SegmentAnswer answer = searchOf({"liver"}).find("spleen");
  EXPECT_EQ(answer.kind, AnswerKind::NotInVolume);
  EXPECT_NE(answer.sentence.find("not in this volume"), std::string::npos);
  EXPECT_TRUE(answer.candidates.empty());
  EXPECT_EQ(searchOf({"liver"}).find("bicycle").kind, AnswerKind::NoMatch);
  const SegmentSearch empty(Lexicon::standard(), {{"liver", false}});
  EXPECT_EQ(empty.find("liver").kind, AnswerKind::NotInVolume);
}

TEST(SegmentSearch, SegmentsThatHoldMoreSaySo) {
  const SegmentSearch search = searchOf({"liver", "bladder", "lungs", "kidneys", "bone", "brain"}); // CT-ORG
  EXPECT_EQ(leadingOf(search.find("lungs")), std::vector<int>{2});
  EXPECT_EQ(leadingOf(search.find("urinary bladder")), std::vector<int>{1});
  EXPECT_EQ(leadingOf(search.find("skeleton")), std::vector<int>{4});
  const SegmentAnswer answer = search.find("left kidney");
  EXPECT_EQ(answer.kind, AnswerKind::Wider);
  ASSERT_EQ(leadingOf(answer), std::vector<int>{3});
  EXPECT_TRUE(answer.candidates[0].wider);
  EXPECT_EQ(search.find("seventh rib").kind, AnswerKind::Wider);
}

TEST(SegmentSearch, OwnNamesComeFirst) {
  const SegmentSearch search = searchOf({"liver", "liver mass", "ROI 7"});
  EXPECT_EQ(leadingOf(search.find("Liver mass")), std::vector<int>{1});
  EXPECT_EQ(leadingOf(search.find("roi_7")), std::vector<int>{2});
  EXPECT_EQ(leadingOf(search.find("the liver")), std::vector<int>{0});
}

TEST(SegmentSearch, AsksForNames) {
  EXPECT_THROW(searchOf({"liver", ""}), Error);
  EXPECT_THROW(searchOf({"liver"}).find(""), Error);
}

/// Meanings by hand: words near the heart, or near the kidneys.
class FakeEmbedding : public SentenceEmbedding {
public:
  std::vector<std::vector<float>> encode(const std::vector<std::string>& texts) override {
    std::vector<std::vector<float>> all;
    for (const std::string& text : texts) {
      const auto has = [&](const char* word) { return text.find(word) != std::string::npos; };
      if (has("heart") || has("pump"))
        all.push_back({1, 0, 0});
      else if (has("kidney") || has("filter"))
        all.push_back({0.6f, 0.8f, 0});
      else
        all.push_back({0, 0, 1});
      ++encoded;
    }
    return all;
  }
  int encoded = 0;
};

TEST(SegmentSearch, WordsBeyondTheLexiconSuggestButNeverChoose) {
  const auto embedding = std::make_shared<FakeEmbedding>();
  SentenceModel model{embedding, {}};
  const SegmentSearch search(
      Lexicon::standard(),
      {{"heart", true}, {"kidney_left", true}, {"kidney_right", true}, {"spleen", true}, {"aorta", false}},
      [&] { return model; });
  EXPECT_EQ(search.find("hepar").kind, AnswerKind::NotInVolume); // the lexicon's answers stay
  EXPECT_EQ(search.find("kidney").kind, AnswerKind::Several);
  EXPECT_EQ(embedding->encoded, 0);
  const SegmentAnswer pump = search.find("blood pump");
  EXPECT_EQ(pump.kind, AnswerKind::Similar);
  EXPECT_EQ(pump.leading, 0u);
  ASSERT_EQ(pump.candidates.size(), 3u); // the spleen's cosine is 0
  EXPECT_EQ(pump.candidates[0].segment, 0);
  EXPECT_NEAR(pump.candidates[0].score, 1, 1e-6);
  EXPECT_NEAR(pump.candidates[1].score, 0.6, 1e-6);
  EXPECT_NE(pump.sentence.find("nearest in meaning: heart, kidney_left, kidney_right"), std::string::npos)
      << pump.sentence;
  const SegmentAnswer left = search.find("left blood filter"); // no suggestion on the other side
  ASSERT_EQ(left.candidates.size(), 2u);
  EXPECT_EQ(left.candidates[0].segment, 1);
  EXPECT_EQ(searchOf({"liver"}).find("blood pump").kind, AnswerKind::NoMatch);
  model = {nullptr, "There is none."};
  const SegmentAnswer without = search.find("blood pump");
  EXPECT_EQ(without.kind, AnswerKind::NoMatch);
  EXPECT_EQ(without.note, "There is none.");
}

} // namespace
} // namespace innergs
