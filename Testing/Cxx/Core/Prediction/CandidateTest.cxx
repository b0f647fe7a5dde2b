#include "Core/Prediction/CandidateChoice.h"

#include "Core/Base/Random.h"
#include "Core/Image/Simulate.h"
#include "Core/Prediction/CandidateGrid.h"
#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <numeric>

namespace innergs::testing {
namespace {

/// Waves of several lengths along every axis; along the third, the shortest has `shortest` voxels.
Volume waves(double shortest) {
  Volume v{grid(48, 44, 49, {1, 1, 1}, {0, 0, 0}, obliqueDirection(0.2)), {}};
  for (std::int64_t k = 0; k < 49; ++k)
    for (std::int64_t j = 0; j < 44; ++j)
      for (std::int64_t i = 0; i < 48; ++i) {
        double sum = 0;
        for (int n = 1; n <= 4; ++n) {
          const double w = 2 * 3.14159265358979 / (shortest * n);
          sum += std::sin(w * i + n) + std::sin(w * j - n) + std::sin(w * k + 2 * n) +
                 std::sin(w * (0.7 * i + 0.7 * k));
        }
        v.voxels.push_back(static_cast<float>(100 + 10 * sum));
      }
  return v;
}

/// Balls with sharp edges.
Volume balls() {
  Volume v = waves(20);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < 49; ++k)
    for (std::int64_t j = 0; j < 44; ++j)
      for (std::int64_t i = 0; i < 48; ++i, ++at) {
        double value = 60;
        for (int b = 0; b < 40; ++b) {
          const double x = i - (7 * b + 3) % 48, y = j - (11 * b + 5) % 44, z = k - (13 * b + 1) % 49;
          if (x * x + y * y + z * z < 30 + b % 5 * 8) value = 80 + 3 * b;
        }
        v.voxels[at] = static_cast<float>(value);
      }
  return v;
}

double mean2(const Volume& a, const std::vector<float>& b, int k) {
  const std::int64_t plane = a.geometry.size[0] * a.geometry.size[1];
  double sum = 0, count = 0;
  for (std::int64_t z = 0; z < a.geometry.size[2]; ++z)
    for (std::int64_t p = z * plane; z % k && p < (z + 1) * plane; ++p, ++count)
      sum += std::pow(static_cast<double>(a.voxels[p]) - b[p], 2);
  return sum / count;
}

TEST(Candidates, KeepSlicesAndConstantsAndFollowLines) {
  std::vector<double> at;
  for (int n = 0; n <= 60; ++n)
    at.push_back(-1 + n * 0.2);
  for (const Candidate c : {Candidate::Linear, Candidate::Cubic, Candidate::Lanczos, Candidate::Kriging}) {
    const SliceWeights w = candidateWeights(c, Kriging(0.4, SliceProfile::Point, 0), 10, at);
    for (std::size_t z = 0; z < at.size(); ++z) {
      EXPECT_NEAR(std::accumulate(w.weight[z].begin(), w.weight[z].end(), 0.0), 1, 1e-5);
      const double inside = std::clamp(at[z], 0.0, 9.0);
      if (std::abs(inside - std::round(inside)) < 1e-9) {
        ASSERT_EQ(w.weight[z].size(), 1u) << candidateName(c);
        EXPECT_EQ(w.first[z], std::llround(inside));
      }
      double line = 0;
      for (std::size_t t = 0; t < w.weight[z].size(); ++t)
        line += w.weight[z][t] * static_cast<double>(w.first[z] + t);
      if (inside > 4 && inside < 5) {
        EXPECT_NEAR(line, inside, c == Candidate::Linear ? 1e-6 : 0.02);
      }
    }
  }
}

TEST(Candidates, NeverLookAtHeldOutOrBrokenVoxels) {
  ThreadPool pool(2);
  Stack stack = keepEvery(balls(), 2, 3);
  const std::int64_t plane = 48 * 44;
  holdOut(stack, {5});
  stack.image.voxels[2 * plane + 700] = std::nanf("");
  const std::vector<float> before = completeSlices(stack, pool);
  const CandidateChoice chosen = chooseCandidates(stack, before, pool);
  for (float& v : std::span(stack.image.voxels).subspan(5 * plane, plane))
    v = -1e6f;
  const std::vector<float> after = completeSlices(stack, pool);
  EXPECT_EQ(before, after);
  EXPECT_EQ(chooseCandidates(stack, after, pool).share, chosen.share);
  for (const float v : after)
    ASSERT_TRUE(std::isfinite(v));
}

TEST(Candidates, AreWeighedAlikeByAnyNumberOfThreads) {
  const Stack stack = simulateThickStack(balls(), 2, 3);
  std::vector<CandidateChoice> choices;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    choices.push_back(chooseCandidates(stack, stack.image.voxels, pool));
  }
  for (const CandidateChoice& choice : choices) {
    EXPECT_EQ(choice.share, choices[0].share);
    EXPECT_EQ(choice.error, choices[0].error);
    EXPECT_EQ(choice.blur, choices[0].blur);
  }
}

/// By how many dB the mixture chosen for every gap-th slice errs more than the best classical interpolation.
double lossToTheBest(const Volume& truth, int gap) {
  ThreadPool pool(2);
  const Stack stack = keepEvery(truth, 2, gap);
  Volume inside = truth;
  inside.geometry.size[2] = (stack.image.geometry.size[2] - 1) * gap + 1;
  const CandidateChoice choice = chooseCandidates(stack, stack.image.voxels, pool);
  EXPECT_TRUE(choice.judged);
  const Kriging kriging = krigingOf(stack, choice.krigingBlur);
  const auto errorWith = [&](const std::array<double, kCandidates>& share) {
    std::vector<float> guess(static_cast<std::size_t>(inside.geometry.voxelCount()));
    applyWeights(combinedWeights(share, kriging, stack.image.geometry.size[2],
                                 planePositions(stack.image.geometry, inside.geometry)),
                 stack.image.voxels, inside.geometry.size[0] * inside.geometry.size[1], guess, pool);
    return mean2(inside, guess, gap);
  };
  double best = std::numeric_limits<double>::infinity();
  for (const Candidate c : {Candidate::Linear, Candidate::Cubic, Candidate::Lanczos}) {
    std::array<double, kCandidates> alone{};
    alone[static_cast<std::size_t>(c)] = 1;
    best = std::min(best, errorWith(alone));
  }
  return 10 * std::log10(errorWith(choice.share) / best);
}

TEST(Candidates, AreHardlyBelowTheBestClassicalOneSmoothOrSharp) {
  for (const Volume& truth : {waves(7), waves(12), balls()})
    for (const int gap : {2, 3, 4})
      EXPECT_LT(lossToTheBest(truth, gap), 0.25) << gap;
}

/// Waves of 9 to 18 mm across 1 mm pixels and slices, and independent ones in every row of 4 mm pixels.
Volume rows() {
  Volume v{grid(24, 96, 49, {4, 1, 1}), std::vector<float>(24 * 96 * 49)};
  Random random(7);
  for (int i = 0; i < 24; ++i)
    for (int n = 0; n < 12; ++n) {
      const double w = 2 * std::numbers::pi / (9 + 9 * random.uniform()),
                   turn = 2 * std::numbers::pi * random.uniform(), phase = 6 * random.uniform();
      for (int k = 0; k < 49; ++k)
        for (int j = 0; j < 96; ++j)
          v.voxels[i + 24 * (j + 96 * k)] +=
              static_cast<float>(std::sin(w * (std::cos(turn) * j + std::sin(turn) * k) + phase));
    }
  return v;
}

TEST(Candidates, AreNotChosenByPixelsCoarserThanTheSlices) {
  for (const int gap : {2, 3})
    EXPECT_LT(lossToTheBest(rows(), gap), 0.25) << gap;
}

TEST(CandidateGrid, HoldsThePlanesOfACoarserGrid) {
  const GridGeometry slices = grid(30, 30, 6, {1, 1, 10}, {3, 4, 5});
  const double spacings[][2] = {{1.5, 0.75}, {2.5, 2.5 / 3}, {5, 1}, {10, 1}};
  for (const auto& [wanted, made] : spacings) {
    const GridGeometry output = grid(30, 30, 20, {1, 1, wanted}, {3, 4, 5 + 2 * wanted});
    const GridGeometry candidates = candidateGrid(slices, output);
    EXPECT_NEAR(candidates.spacing[2], made, 1e-9);
    const double plane = (output.origin[2] - candidates.origin[2]) / made;
    EXPECT_NEAR(plane, std::round(plane), 1e-6) << wanted;
  }
}

TEST(CandidateGrid, IsInStepWithTheGridThatIsWanted) {
  const Volume truth = balls();
  for (const int gap : {2, 3, 4}) {
    const Stack kept = keepEvery(truth, 2, gap), thick = simulateThickStack(truth, 2, gap);
    for (const Stack* stack : {&kept, &thick}) {
      const GridGeometry candidates = candidateGrid(stack->image.geometry, truth.geometry);
      const Affine3 map = inverse(truth.geometry.indexToWorld()) * candidates.indexToWorld();
      EXPECT_NEAR(map.offset[2], std::round(map.offset[2]), 1e-6);
      EXPECT_NEAR(candidates.spacing[2], 1, 1e-9);
      const std::vector<double> at = planePositions(stack->image.geometry, candidates);
      EXPECT_LE(at.front() - 0.5 / gap, -0.5 + 1e-6);
      EXPECT_GE(at.back() + 0.5 / gap, static_cast<double>(stack->image.geometry.size[2]) - 0.5 - 1e-6);
      EXPECT_LT(candidates.size[2], gap * stack->image.geometry.size[2] + 2);
    }
    GridGeometry other = truth.geometry;
    other.direction = obliqueDirection(0.7);
    EXPECT_NEAR(candidateGrid(kept.image.geometry, other).spacing[2], 1, 0.05);
  }
}

} // namespace
} // namespace innergs::testing
