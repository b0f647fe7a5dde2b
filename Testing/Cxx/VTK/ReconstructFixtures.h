#pragma once
#include "../Core/Alignment/HeadPhantom.h"
#include "Core/Image/Simulate.h"
#include "Fixtures.h"

namespace innergs::testing {

struct Pose {
  const char* name;
  double angle;
  bool leftHanded;
};

inline ReconstructionInput posedInput(const Pose& pose, bool thick) {
  const Volume truth =
      phantom(grid(22, 20, 18, {1.1, 0.9, 1}, {-30, 12, 5}, obliqueDirection(pose.angle, pose.leftHanded)));
  return inputOf({thick ? simulateThickStack(truth, 2, 3) : pointStack(truth)});
}

/// Two scans of 4 mm slices of a head, which suffice for its uncertainty.
inline ReconstructionInput headInput() {
  const Volume truth = headPhantom(56);
  ReconstructionInput input;
  for (int s = 0; s < 2; ++s)
    input.stacks.push_back(simulateThickStack(truth, 2 - s, 4, 5, static_cast<std::uint64_t>(s) + 1));
  return input;
}

/// Equal up to the rounding in a matrix: a fit depends on its input's last bit.
inline void expectSame(vtkInnerGSReconstruct* filter, const ReconstructionResult& expected) {
  ASSERT_EQ(filter->GetErrorMessage(), "");
  EXPECT_EQ(filter->GetOutputModel()->GetNumberOfGaussians(), expected.model->field.size());
  EXPECT_EQ(filter->GetOutputModel()->GetNumberOfIterations(), expected.iterations);
  const auto values = valuesOf(filter->GetOutputImage());
  ASSERT_EQ(values.size(), expected.volume.voxels.size());
  EXPECT_GT(psnr({{}, values}, expected.volume), 58);
  EXPECT_TRUE(closeTo(filter->GetOutputIJKToRASMatrix(), rasMatrix(expected.volume.geometry), 1e-9));
  int size[3];
  filter->GetOutputImage()->GetDimensions(size);
  for (int a = 0; a < 3; ++a)
    EXPECT_EQ(size[a], expected.volume.geometry.size[a]);
}

} // namespace innergs::testing
