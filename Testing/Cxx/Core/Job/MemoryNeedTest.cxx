#include "Core/Job/MemoryEstimate.h"

#include "Core/Base/SystemMemory.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

#include <array>

using namespace innergs;

namespace {

ReconstructionInput outline(std::int64_t side) {
  ReconstructionInput input;
  input.stacks.emplace_back().image.geometry.size = {side, side, 20};
  input.stacks.front().image.geometry.spacing = {1, 1, 5};
  return input;
}

} // namespace

TEST(MemoryNeed, IsTheLargestOfTheFitsAndKeepsResults) {
  const Settings settings;
  const std::array fits{outline(64), outline(128)};
  const std::int64_t small = estimateMemory(fits[0], settings), large = estimateMemory(fits[1], settings);
  EXPECT_EQ(memoryNeed({fits.data(), 1}, settings, 0).bytes, small);
  EXPECT_GT(memoryNeed(fits, settings, 0).bytes, large); // plus the first one's result
  const std::array turned{fits[1], fits[0]};
  EXPECT_EQ(memoryNeed(turned, settings, 0).bytes, large);
  EXPECT_TRUE(memoryNeed(fits, settings, 0).refusal.empty()); // unknown
  EXPECT_TRUE(memoryNeed(fits, settings, 2 * large).refusal.empty());
}

TEST(MemoryNeed, CountsThePredictedVolume) {
  const ReconstructionInput scan = outline(128); // fills 128 × 128 × 100 voxels
  Settings settings;
  settings.preset = Preset::Fast;
  const std::int64_t predicted = estimateMemory(scan, settings);
  settings.prediction = PredictionKind::None;
  EXPECT_GT(predicted, estimateMemory(scan, settings) + std::int64_t{4} * 128 * 128 * 100);
}

TEST(MemoryNeed, RefusesWithTheJobsOwnSentence) {
  // Outlines suffice: the job refuses before it reads a voxel.
  ReconstructionInput input = outline(64);
  GridGeometry huge = input.stacks.front().image.geometry;
  huge.size = {100'000, 100'000, 1'000};
  input.outputGrid = huge;
  if (availableMemory() == 0) GTEST_SKIP() << "This system does not say how much memory is available.";
  const std::string refusal = memoryNeed({&input, 1}, {}).refusal;
  EXPECT_EQ(refusal.find("The reconstruction needs about "), 0u) << refusal;
  input.stacks.front().image.voxels.assign(64 * 64 * 20, 1.f);
  const Error error = test::errorOf([&] { ReconstructionJob(input, {}).run({}); });
  EXPECT_EQ(error.code(), ErrorCode::Memory);
  const std::string sentence = error.what(); // the available memory changes from moment to moment
  EXPECT_EQ(sentence.substr(0, sentence.find(", but only ")), refusal.substr(0, refusal.find(", but only ")));
  EXPECT_EQ(sentence.substr(sentence.find(" is available")), refusal.substr(refusal.find(" is available")));
}

TEST(MemoryNeed, SaysWhenOnlyTheJudgingIsTooLarge) {
  const Settings settings;
  const std::array fits{outline(64), outline(512)};
  const MemoryNeed need = memoryNeed(fits, settings, estimateMemory(fits[0], settings) + 1'000'000);
  EXPECT_EQ(need.refusal.find("Judging the quality needs about "), 0u) << need.refusal;
}

TEST(MemoryNeed, CountsWhatTheUncertaintyKeeps) {
  const Settings settings;
  ReconstructionInput judged = outline(256), uncertain = judged;
  judged.heldOutFraction = 0.2;
  uncertain.uncertainty = true; // holds out as many
  const std::int64_t voxels = 256 * 256 * 20;
  const std::int64_t more = estimateMemory(uncertain, settings) - estimateMemory(judged, settings);
  EXPECT_GE(more, 5 * voxels) << "the scans as they lie, and what was seen of held-out slices";
  EXPECT_LT(more, 2 * estimateMemory(judged, settings));
}
