#include "Core/Motion/MotionField.h"

#include "Core/Base/Error.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

/// Tissue that moves by τ·(A·x + b) from the canonical place x, τ running from 0 to 3 over [0 s, 6 s]: linear
/// in space and time, so that grid and spline hold it exactly.
struct LinearMotion {
  Mat3 a{{{{0.02, 0.05, 0}, {-0.04, 0.01, 0.03}, {0, 0.02, -0.03}}}};
  Vec3 b{1.2, -0.7, 0.4};
  static double tau(double time) { return 0.5 * time; }
  Vec3 at(const Vec3& x, double time) const { return x + tau(time) * (a * x + b); }
};

DynamicField dynamicField(const LinearMotion& motion) {
  DynamicField field;
  field.times = {0, 2, 4, 6};
  // A model frame that is turned and shifted against the world.
  field.canonical.modelToWorld.linear = Mat3{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}};
  field.canonical.modelToWorld.offset = {3, -2, 5};
  const Affine3 toWorld = field.canonical.modelToWorld, toModel = inverse(toWorld);
  field.motionGrid = motionGridOver({-40, -40, -40}, {40, 40, 40}, {10, 10, 10});
  field.motion = {0, 6, 4}; // one span; evenly rising coefficients make a straight line
  for (int c = 0; c < 4; ++c)
    for (std::int64_t n = 0; n < field.motionGrid.nodes(); ++n) {
      const auto& size = field.motionGrid.size;
      const std::int64_t index[3] = {n % size[0], n / size[0] % size[1], n / (size[0] * size[1])};
      Vec3 x;
      for (int axis = 0; axis < 3; ++axis)
        x[axis] =
            field.motionGrid.origin[axis] + static_cast<double>(index[axis]) * field.motionGrid.spacing[axis];
      const Vec3 world = motion.a * toWorld(x) + motion.b;
      const Vec3 u = 3.0 * (c - 1) * (toModel.linear * world); // Greville points −1, 0, 1, 2 of the span
      for (int axis = 0; axis < 3; ++axis)
        field.nodes.push_back(static_cast<float>(u[axis]));
      field.nodes.insert(field.nodes.end(), 3, 0.f);
    }
  return field;
}

TEST(MotionField, LeadsFromOneTimeToTheOther) {
  const LinearMotion motion;
  const DynamicField field = dynamicField(motion);
  const GridGeometry geometry = grid(5, 4, 3, {2, 2.5, 3}, {-5, -4, 2});
  const double from = 1.5, to = 4.5;
  const std::vector<float> d = motionField(field, from, to, geometry);
  std::size_t n = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i) {
        const Vec3 canonical = geometry.indexToWorld()({0.9 * i, 0.9 * j, 0.8 * k});
        // The field at the place where that tissue is at `from`: sampled there, on a grid of one voxel.
        const Vec3 x = motion.at(canonical, from);
        const std::vector<float> there = motionField(field, from, to, grid(1, 1, 1, {1, 1, 1}, x));
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_NEAR(there[axis], motion.at(canonical, to)[axis] - x[axis], 1e-3) << n;
        n += 3;
      }
  ASSERT_EQ(d.size(), n);
  for (const float still : motionField(field, from, from, geometry))
    EXPECT_NEAR(still, 0, 1e-3);
  EXPECT_EQ(motionField(field, from, to, geometry, 1), d);
}

TEST(MotionField, NeedsGaussiansThatMove) {
  DynamicField field = dynamicField({});
  field.kind = DynamicKind::Intensity;
  EXPECT_THROW(motionField(field, 0, 1, grid(2, 2, 2)), Error);
  field.kind = DynamicKind::Motion;
  EXPECT_THROW(motionField(field, 0, std::numeric_limits<double>::quiet_NaN(), grid(2, 2, 2)), Error);
}

} // namespace
} // namespace innergs::testing
