#include "Core/Image/Region.h"

#include "Allocations.h"
#include "Fixtures.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// Number of voxels (floats) that TakeSnapshot() copied.
double copied(vtkInnerGSReconstruct* filter) {
  resetLargeAllocations();
  EXPECT_TRUE(filter->TakeSnapshot()) << filter->GetErrorMessage();
  return static_cast<double>(largeAllocations()) / sizeof(float);
}

ReconstructionInput largeInput() {
  return inputOf({pointStack(phantom(grid(64, 60, 56, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3))))});
}

} // namespace

TEST(Snapshot, CopiesEveryVoxelOnceWhateverTheSliceAxis) {
  const double voxels = 64 * 60 * 56;
  for (const int axis : {0, 1, 2})
    for (const int type : {VTK_SHORT, VTK_FLOAT}) {
      auto filter = quickFilter({});
      addInput(filter, 0, largeInput().stacks[0], type);
      filter->SetInputSliceAxis(0, axis);
      EXPECT_EQ(copied(filter), voxels) << axis;
    }
}

TEST(Snapshot, CopiesOnlyWhatTheRegionNeeds) {
  const ReconstructionInput input = largeInput();
  const GridGeometry& g = input.stacks[0].image.geometry;
  const Vec3 c = g.centre();
  for (const int axis : {2, 0}) {
    auto filter = quickFilter(input);
    filter->SetInputSliceAxis(0, axis);
    // Along the grid's axes: the block is the box plus its margin of two slices.
    filter->SetRegion(-20, 20, -15, 15, -10, 10);
    filter->SetRegionToRASMatrix(rasMatrix(Affine3{g.direction, c}));
    filter->UseRegionOn();
    EXPECT_EQ(copied(filter), 44 * 34 * 24) << axis;
  }
}

TEST(Snapshot, OfATurnedRegionMarksWhatIsInsideAByteAVoxel) {
  const ReconstructionInput input = largeInput();
  const GridGeometry& g = input.stacks[0].image.geometry;
  auto filter = quickFilter(input);
  const Vec3 c = g.centre();
  filter->SetRegion(-c[0] - 15, -c[0] + 15, -c[1] - 12, -c[1] + 12, c[2] - 12,
                    c[2] + 12); // oblique to the grid
  filter->UseRegionOn();
  const double block = static_cast<double>(
      cropped(g, Region{{c[0] - 15, c[1] - 12, c[2] - 12}, {c[0] + 15, c[1] + 12, c[2] + 12}}, 2)
          .voxelCount());
  const double bytes = 4 * copied(filter);
  EXPECT_GE(bytes, 4 * block);
  EXPECT_LE(bytes, 5 * block);
}
