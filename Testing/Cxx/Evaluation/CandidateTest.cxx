#include "Core/Image/Simulate.h"
#include "Core/Prediction/CandidateWeights.h"
#include "Evaluation/Baselines.h"

#include <gtest/gtest.h>
#include <random>

namespace innergs {
namespace {

TEST(Candidates, AreTheBaselinesToRounding) {
  Volume truth{{{14, 11, 40}, {3, -2, 7}, {0.8, 0.8, 0.8}, {}}, {}};
  std::mt19937 engine(3);
  for (std::int64_t v = 0; v < truth.geometry.voxelCount(); ++v)
    truth.voxels.push_back(static_cast<float>(engine() % 1000));
  ThreadPool pool(2);
  for (const int gap : {2, 3, 5}) {
    const Stack kept = keepEvery(truth, 2, gap), thick = simulateThickStack(truth, 2, gap);
    for (const Stack* stack : {&kept, &thick}) {
      const std::vector<double> at = planePositions(stack->image.geometry, truth.geometry);
      const std::pair<Candidate, Interpolation> kinds[] = {{Candidate::Linear, Interpolation::Linear},
                                                           {Candidate::Cubic, Interpolation::Cubic},
                                                           {Candidate::Lanczos, Interpolation::Lanczos}};
      for (const auto& [candidate, baseline] : kinds) {
        std::vector<float> found(truth.voxels.size());
        applyWeights(candidateWeights(candidate, krigingOf(*stack, 0), stack->image.geometry.size[2], at),
                     stack->image.voxels, 14 * 11, found, pool);
        const Volume expected = averageUpsampled({stack, 1}, truth.geometry, baseline, 2);
        for (std::size_t v = 0; v < found.size(); ++v)
          ASSERT_NEAR(found[v], expected.voxels[v], 2e-2) << candidateName(candidate) << " " << gap;
      }
    }
  }
}

} // namespace
} // namespace innergs
