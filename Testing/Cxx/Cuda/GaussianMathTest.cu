// The mathematics shared by all backends must give the same results on the device and on the host.
#include "Core/Model/GaussianMath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace {

using namespace innergs::math;

struct Case {
  float quaternion[4], logScale[3], gradient[6], moments[14], toModel[9];
};

struct Result {
  float rotation[9], covariance[6], precision[6], row[5], dLogScale[3], dQuaternion[4], moments[14];
};

INNERGS_HD void evaluate(const Case& c, Result& r) {
  rotation(c.quaternion, r.rotation);
  float scaled[9];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      scaled[3 * i + k] = r.rotation[3 * i + k] * std::exp(c.logScale[k]);
  outer(scaled, r.covariance);
  invertSymmetric(r.covariance, r.precision);
  const RowForm<float> form = rowForm(r.precision);
  const float row[5] = {form.pxx, form.l1, form.l2, form.b, form.l3};
  for (int i = 0; i < 5; ++i)
    r.row[i] = row[i];
  precisionGradient(c.gradient, c.logScale, c.quaternion, r.dLogScale, r.dQuaternion);
  Moments<float> m;
  m.m0 = c.moments[0];
  m.n0 = c.moments[1];
  for (int i = 0; i < 3; ++i) {
    m.m1[i] = c.moments[2 + i];
    m.n1[i] = c.moments[5 + i];
  }
  for (int i = 0; i < 6; ++i)
    m.m2[i] = c.moments[8 + i];
  const Moments<float> t = transformMoments(m, c.toModel);
  r.moments[0] = t.m0;
  r.moments[1] = t.n0;
  for (int i = 0; i < 3; ++i) {
    r.moments[2 + i] = t.m1[i];
    r.moments[5 + i] = t.n1[i];
  }
  for (int i = 0; i < 6; ++i)
    r.moments[8 + i] = t.m2[i];
}

__global__ void evaluateAll(const Case* cases, Result* results, int count) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < count) evaluate(cases[i], results[i]);
}

TEST(GaussianMathOnTheDevice, AgreesWithTheHost) {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0)
    GTEST_SKIP() << "No CUDA device here: the code was compiled for one, not run.";
  constexpr int count = 10000;
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Case> cases(count);
  for (Case& c : cases)
    for (std::size_t i = 0; i < sizeof(Case) / sizeof(float); ++i)
      reinterpret_cast<float*>(&c)[i] = uniform(engine);
  Case* deviceCases = nullptr;
  Result* deviceResults = nullptr;
  ASSERT_EQ(cudaMalloc(&deviceCases, count * sizeof(Case)), cudaSuccess);
  ASSERT_EQ(cudaMalloc(&deviceResults, count * sizeof(Result)), cudaSuccess);
  ASSERT_EQ(cudaMemcpy(deviceCases, cases.data(), count * sizeof(Case), cudaMemcpyHostToDevice), cudaSuccess);
  evaluateAll<<<(count + 127) / 128, 128>>>(deviceCases, deviceResults, count);
  std::vector<Result> device(count);
  ASSERT_EQ(cudaMemcpy(device.data(), deviceResults, count * sizeof(Result), cudaMemcpyDeviceToHost),
            cudaSuccess);
  cudaFree(deviceCases);
  cudaFree(deviceResults);
  for (int i = 0; i < count; ++i) {
    Result host;
    evaluate(cases[i], host);
    const float* a = reinterpret_cast<const float*>(&host);
    const float* b = reinterpret_cast<const float*>(&device[i]);
    for (std::size_t k = 0; k < sizeof(Result) / sizeof(float); ++k)
      ASSERT_NEAR(a[k], b[k], 1e-4f * std::max(1.f, std::fabs(a[k]))) << "case " << i << ", value " << k;
  }
}

} // namespace
