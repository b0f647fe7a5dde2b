#include "Core/Motion/Pose.h"

#include "Core/Base/Random.h"
#include "Core/Model/GaussianMath.h"

#include <gtest/gtest.h>

using namespace innergs;

namespace {

constexpr int kValues = MotionGrid::kValues;

double scalar(const GaussianField& field, const std::vector<float>& weights) {
  double sum = 0;
  for (std::size_t i = 0; i < field.gaussians.size(); ++i) {
    const float* x = reinterpret_cast<const float*>(&field.gaussians[i]);
    for (int p = 0; p < 16; ++p)
      sum += static_cast<double>(weights[16 * i + p]) * static_cast<double>(x[p]);
  }
  return sum;
}

class PoseGradient : public ::testing::Test {
protected:
  PoseGradient() {
    Random random(3);
    const auto draw = [&](double reach) { return static_cast<float>(reach * (2 * random.uniform() - 1)); };
    field.motionGrid = motionGridOver({-6, -6, -6}, {6, 6, 6}, {4, 5, 12});
    field.motion = {0, 3, 5};
    field.own = {0, 3, 4};
    for (int i = 0; i < 20; ++i) {
      Gaussian g{};
      for (float& x : g.mean)
        x = draw(7); // some beyond the grid
      for (float& q : g.quaternion)
        q = draw(1);
      g.intensity = draw(1);
      field.canonical.gaussians.push_back(g);
      field.anchors.insert(field.anchors.end(), g.mean, g.mean + 3);
    }
    field.nodes.resize(field.motionGrid.nodes() * kValues * field.motion.coefficients);
    field.ownPath.resize(3 * field.canonical.gaussians.size() * field.own.coefficients);
    for (auto* values : {&field.nodes, &field.ownPath})
      for (float& v : *values)
        v = draw(0.6);
    weights.resize(16 * field.canonical.gaussians.size());
    for (float& w : weights)
      w = draw(1);
    posed = field.canonical;
  }

  double at(double time) {
    poseAt(field, time, posed, pool);
    return scalar(posed, weights);
  }
  double difference(float& x, double time) {
    const float before = x, step = 1e-2F;
    x = before + step;
    const double high = at(time);
    x = before - step;
    const double low = at(time);
    x = before;
    return (high - low) / (2 * static_cast<double>(step));
  }

  DynamicField field;
  GaussianField posed;
  std::vector<float> weights;
  ThreadPool pool{2};
};

} // namespace

TEST_F(PoseGradient, OfGridAndCanonicalGaussiansIsTheDifferenceQuotient) {
  const double time = 1.3;
  const std::vector<float> nodes = nodesAt(field, time);
  std::vector<float> gradient = weights, nodeGradient(nodes.size(), 0.f);
  Poser(field).backward(field, nodes, gradient, nodeGradient, pool);
  const auto w = field.motion.at(time);
  for (std::size_t v = 0; v < nodes.size(); v += 5)
    for (int a = 0; a < w.count; ++a)
      EXPECT_NEAR(difference(field.nodes[(w.first + a) * nodes.size() + v], time),
                  w.weight[a] * nodeGradient[v], 2e-3)
          << v;
  for (std::size_t i = 0; i < field.canonical.gaussians.size(); i += 3) {
    float* x = reinterpret_cast<float*>(&field.canonical.gaussians[i]);
    for (int p = 0; p < 12; ++p)
      EXPECT_NEAR(difference(x[p], time), gradient[16 * i + p], 2e-3) << i << ", " << p;
  }
  const auto own = field.own.at(time);
  for (std::size_t c = 0; c < 9; ++c)
    EXPECT_NEAR(difference(field.ownPath[own.first * 3 * field.size() + c], time),
                own.weight[0] * gradient[16 * (c / 3) + c % 3], 2e-3);
}

TEST_F(PoseGradient, OfBendingIsTheDifferenceQuotient) {
  std::vector<float> values(field.nodes.begin(), field.nodes.begin() + field.motionGrid.nodes() * kValues);
  std::vector<float> gradient(values.size(), 0.f), other(values.size());
  addBending(field.motionGrid, values, 3, 0.7, gradient);
  for (std::size_t v = 0; v < values.size(); v += 3) {
    const float before = values[v];
    values[v] = before + 0.01F;
    const double high = addBending(field.motionGrid, values, 3, 0.7, other);
    values[v] = before - 0.01F;
    const double low = addBending(field.motionGrid, values, 3, 0.7, other);
    values[v] = before;
    EXPECT_NEAR((high - low) / 0.02, gradient[v], 2e-2 + 1e-3 * std::abs(gradient[v]));
  }
}

TEST_F(PoseGradient, BendingOfARigidMotionIsNothing) {
  std::vector<float> values, gradient(field.motionGrid.nodes() * kValues, 0.f);
  const auto& n = field.motionGrid.size;
  for (std::int64_t node = 0; node < field.motionGrid.nodes(); ++node) {
    const auto x = static_cast<float>(node % n[0]), y = static_cast<float>(node / n[0] % n[1]);
    values.insert(values.end(), {0.3F * x - 0.1F * y, 0.2F * y, 1.F, 0.F, 0.F, 0.4F});
  }
  EXPECT_NEAR(addBending(field.motionGrid, values, 1, 1, gradient), 0, 1e-8);
}

TEST_F(PoseGradient, RotationVectorTurnsByTwiceTheArcTangent) {
  std::fill(field.nodes.begin(), field.nodes.end(), 0.f);
  field.ownPath.clear();
  const double angle = 0.5;
  for (std::size_t v = 5; v < field.nodes.size(); v += kValues)
    field.nodes[v] = static_cast<float>(2 * std::tan(angle / 2)); // about z
  Gaussian& g = field.canonical.gaussians[0];
  const float still[4] = {1, 0, 0, 0};
  std::copy(still, still + 4, g.quaternion);
  poseAt(field, 1, posed, pool);
  float r[9];
  math::rotation(posed.gaussians[0].quaternion, r);
  EXPECT_NEAR(r[0], std::cos(angle), 1e-6);
  EXPECT_NEAR(r[3], std::sin(angle), 1e-6);
}
