#include "Core/Motion/DeformationNetwork.h"

#include "Core/Base/Error.h"
#include "Core/Base/Random.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace innergs;

namespace {

class DeformationNetworkTest : public ::testing::Test {
protected:
  DeformationNetworkTest() {
    network.levels = {{{3, 2, 4}, 4}, {{5, 4, 6}, 5}};
    network.low = {-4, -3, 0};
    network.high = {4, 3, 9};
    network.start = 1;
    network.end = 4;
    network.scale = {2, 2, 2, 0.5F, 0.5F, 0.5F, 1, 1, 1, 1, 0.1F, 0.3F, 0, 0, 0, 0};
    initialise(network, 5);
    for (float& p : network.parameters)
      p += draw(0.1); // the heads begin at 0
    for (int i = 0; i < 3 * kPoints; ++i)
      points.push_back(draw(5)); // some beyond the box
    for (int i = 0; i < DeformationNetwork::kOutputs * kPoints; ++i)
      weights.push_back(draw(1));
  }

  float draw(double reach) { return static_cast<float>(reach * (2 * random.uniform() - 1)); }

  std::vector<float> outputs(double time, const NetworkKernels& kernels) {
    std::vector<float> out(weights.size());
    DeformationEvaluator(network, points, kernels).forward(network, time, out, pool);
    return out;
  }

  std::vector<float> gradient(double time, const NetworkKernels& kernels, ThreadPool& by) {
    std::vector<float> sum(network.parameters.size(), 0.F);
    DeformationEvaluator(network, points, kernels).backward(network, time, weights, sum, by);
    return sum;
  }

  double loss(double time) {
    const std::vector<float> out = outputs(time, scalarNetworkKernels());
    double sum = 0;
    for (std::size_t i = 0; i < out.size(); ++i)
      sum += static_cast<double>(weights[i]) * static_cast<double>(out[i]);
    return sum;
  }

  static constexpr int kPoints = 300; // more than a block
  Random random{7};
  DeformationNetwork network;
  std::vector<float> points, weights;
  ThreadPool pool{2};
};

} // namespace

TEST_F(DeformationNetworkTest, GradientIsTheDifferenceQuotient) {
  const NetworkKernels kernels = scalarNetworkKernels();
  for (const double time : {1.0, 2.3, 4.0, 5.0}) {
    const std::vector<float> analytic = gradient(time, kernels, pool);
    int moved = 0;
    double difference = 0, size = 0;
    for (std::size_t i = random.next() % 71; i < analytic.size(); i += 71) {
      float& p = network.parameters[i];
      const float before = p;
      constexpr float step = 2e-3F; // a few rectifiers turn within it
      p = before + step;
      const double high = loss(time);
      p = before - step;
      const double low = loss(time);
      p = before;
      const double quotient = (high - low) / (2 * static_cast<double>(step));
      difference += std::pow(quotient - static_cast<double>(analytic[i]), 2);
      size += quotient * quotient;
      moved += quotient != 0;
    }
    EXPECT_GT(moved, 40) << time;
    EXPECT_LT(std::sqrt(difference / size), 0.02) << time;
  }
}

TEST_F(DeformationNetworkTest, InstructionSetsAgreeWithThePlainOne) {
  const auto close = [](const std::vector<float>& a, const std::vector<float>& b, const std::string& name) {
    double most = 0, size = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      most = std::max(most, static_cast<double>(std::fabs(a[i] - b[i])));
      size = std::max(size, static_cast<double>(std::fabs(b[i])));
    }
    EXPECT_GT(size, 0) << name;
    EXPECT_LT(most, 2e-5 * size) << name;
  };
  const NetworkKernels plain = scalarNetworkKernels();
  for (const NetworkKernels& kernels : networkKernelSets()) {
    close(outputs(2.3, kernels), outputs(2.3, plain), kernels.name);
    close(gradient(2.3, kernels, pool), gradient(2.3, plain, pool), kernels.name);
  }
}

TEST_F(DeformationNetworkTest, SameBitsAtAnyNumberOfThreads) {
  const NetworkKernels& kernels = networkKernels("");
  ThreadPool one(1), five(5);
  EXPECT_EQ(gradient(1.7, kernels, one), gradient(1.7, kernels, five));
}

TEST_F(DeformationNetworkTest, ChangesNothingAtTheStart) {
  initialise(network, 5);
  for (const float x : outputs(2, networkKernels("")))
    ASSERT_EQ(x, 0);
}

TEST_F(DeformationNetworkTest, PlacesAndTimesBeyondTheBoxCountAsItsBorder) {
  points = {9, -8, 20, 4, -3, 9};
  weights.resize(2 * DeformationNetwork::kOutputs);
  const std::vector<float> beyond = outputs(7, networkKernels(""));
  for (int i = 0; i < DeformationNetwork::kOutputs; ++i)
    EXPECT_EQ(beyond[i], beyond[DeformationNetwork::kOutputs + i]);
  EXPECT_EQ(beyond, outputs(4, networkKernels("")));
}

TEST_F(DeformationNetworkTest, SmoothnessPullsPlanesTowardsNoChange) {
  std::vector<float> inTime(network.parameters.size(), 0.F), inSpace = inTime, none = inTime;
  addPlaneSmoothness(network, 1, 0, inTime);
  addPlaneSmoothness(network, 0, 1, inSpace);
  // The first level has 3×2, 3×4 and 2×4 nodes over space, then 3×4 over (x,t).
  const float* p = network.parameters.data();
  constexpr std::size_t c = DeformationNetwork::kChannels, xt = (3 * 2 + 3 * 4 + 2 * 4) * c, row = 3 * c;
  for (std::size_t i = 0; i < row; ++i) {
    const float second = p[xt + i] - 2 * p[xt + row + i] + p[xt + 2 * row + i];
    EXPECT_NEAR(inTime[xt + i], 2 * second, 1e-5F);
    const float next = p[xt + row + i] - 2 * p[xt + 2 * row + i] + p[xt + 3 * row + i];
    EXPECT_NEAR(inTime[xt + row + i], -4 * second + 2 * next, 1e-5F);
    EXPECT_EQ(inSpace[xt + i], 0);
  }
  for (std::size_t i = 0; i < c; ++i) { // the first node of the first plane
    EXPECT_NEAR(inSpace[i], 2 * (2 * p[i] - p[i + c] - p[i + 3 * c]), 1e-5F);
    EXPECT_EQ(inTime[i], 0);
  }
  for (std::size_t i = network.planeParameters(); i < inTime.size(); ++i)
    ASSERT_EQ(inTime[i] + inSpace[i], 0);
  std::fill(network.parameters.begin(), network.parameters.end(), 2.F);
  addPlaneSmoothness(network, 1, 1, none);
  for (const float g : none)
    ASSERT_EQ(g, 0);
}

TEST_F(DeformationNetworkTest, BrokenOnesAreRefused) {
  EXPECT_NO_THROW(checkDeformation(network));
  const auto refused = [&](const auto& change) {
    DeformationNetwork broken = network;
    change(broken);
    EXPECT_THROW(checkDeformation(broken), Error);
  };
  refused([](DeformationNetwork& n) { n.levels.clear(); });
  refused([](DeformationNetwork& n) { n.levels[0].size[1] = 1; });
  refused([](DeformationNetwork& n) { n.levels[1].times = 3; });
  refused([](DeformationNetwork& n) { n.parameters.pop_back(); });
  refused([](DeformationNetwork& n) { n.parameters[3] = std::nanf(""); });
  refused([](DeformationNetwork& n) { n.scale[3] = std::nanf(""); });
  refused([](DeformationNetwork& n) { n.high[2] = n.low[2]; });
  refused([](DeformationNetwork& n) { n.end = n.start; });
}
