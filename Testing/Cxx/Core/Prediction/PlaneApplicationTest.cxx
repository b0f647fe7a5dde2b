#include "Core/Prediction/PlaneApplication.h"
#include "Core/Base/Random.h"
#include "TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace innergs {
namespace {

using testing::grid;
using testing::randomVolume;

constexpr int kPhases = 4;
constexpr std::array<std::int64_t, 3> kSize{11, 9, 7};

/// A filter that prefers one side, on slices of 4 mm that touch.
struct Case {
  Volume image = randomVolume(grid(kSize[0], kSize[1], kSize[2], {1, 1, 4}), 0, 100, 3);
  GridGeometry thin = image.geometry;
  SliceModel model;

  Case() {
    Stack stack;
    stack.image = image;
    stack.thickness = 4;
    thin.spacing[2] = 1;
    thin.origin[2] = -1.5;
    thin.size[2] = kPhases * kSize[2];
    model.sampling = sliceSampling(stack, thin, kPhases);
    model.filter.phases = kPhases;
    model.filter.weights.resize(static_cast<std::size_t>(PatchFeatures::stride) * outputStride(kPhases));
    Random random(4);
    for (float& weight : model.filter.weights)
      weight = static_cast<float>(0.1 * (random.uniform() - 0.5));
    model.floor = 1;
  }

  std::array<std::vector<float>, 2> predict(const Volume& from, Reflections reflections) const {
    ThreadPool pool(2);
    const std::vector<std::uint8_t> all(from.voxels.size(), 1);
    return applyAcrossSlices(model, from, all, reflections, networkKernels(""), thin, pool, {});
  }
};

/// Values of a grid of this size, reflected along an axis.
std::vector<float> reflected(const std::vector<float>& values, const std::array<std::int64_t, 3>& n,
                             int axis) {
  std::vector<float> out(values.size());
  for (std::int64_t v = 0; v < static_cast<std::int64_t>(values.size()); ++v) {
    std::int64_t index[] = {v % n[0], v / n[0] % n[1], v / (n[0] * n[1])};
    index[axis] = n[axis] - 1 - index[axis];
    out[static_cast<std::size_t>(index[0] + n[0] * (index[1] + n[1] * index[2]))] = values[v];
  }
  return out;
}

float greatestDifference(const std::vector<float>& a, const std::vector<float>& b) {
  float most = 0;
  for (std::size_t v = 0; v < a.size(); ++v)
    most = std::max(most, std::abs(a[v] - b[v]));
  return most;
}

// All four reflections make of any model one that treats both directions of its planes alike.
TEST(PlaneApplication, FourReflectionsPredictOfAReflectedImageTheReflection) {
  const Case c;
  for (const int axis : {0, 1, 2}) {
    Volume image = c.image;
    image.voxels = reflected(image.voxels, kSize, axis);
    for (const int plane : {0, 1}) {
      const bool within = axis == plane || axis == 2; // the planes along I or J show it
      for (const Reflections reflections : {Reflections::None, Reflections::Four}) {
        const float difference =
            greatestDifference(c.predict(image, reflections)[plane],
                               reflected(c.predict(c.image, reflections)[plane], c.thin.size, axis));
        if (within && reflections == Reflections::None)
          EXPECT_GT(difference, 1) << axis << plane;
        else
          EXPECT_LT(difference, 1e-3) << axis << plane;
      }
    }
  }
}

TEST(PlaneApplication, TwoReflectionsTogetherAreHalfOfTheFour) {
  const Case c;
  const auto once = c.predict(c.image, Reflections::None), twice = c.predict(c.image, Reflections::Two),
             all = c.predict(c.image, Reflections::Four);
  Volume image = c.image; // in the planes along I, the two are none and both
  image.voxels = reflected(reflected(image.voxels, kSize, 0), kSize, 2);
  const std::vector<float> both =
      reflected(reflected(c.predict(image, Reflections::None)[0], c.thin.size, 0), c.thin.size, 2);
  std::vector<float> mean(both.size()), others(both.size());
  for (std::size_t v = 0; v < both.size(); ++v)
    mean[v] = 0.5F * (once[0][v] + both[v]);
  EXPECT_LT(greatestDifference(twice[0], mean), 1e-3);
  // In the planes along J, they are the other two.
  for (std::size_t v = 0; v < both.size(); ++v)
    others[v] = 2 * all[1][v] - twice[1][v];
  image.voxels = reflected(reflected(c.image.voxels, kSize, 1), kSize, 2);
  const std::vector<float> turned =
      reflected(reflected(c.predict(image, Reflections::None)[1], c.thin.size, 1), c.thin.size, 2);
  for (std::size_t v = 0; v < both.size(); ++v)
    mean[v] = 0.5F * (once[1][v] + turned[v]);
  EXPECT_LT(greatestDifference(others, mean), 1e-3);
}

} // namespace
} // namespace innergs
