#include "SegmentationFixture.h"

#include "DetachedTasks.h"
#include "Geometry.h"
#include "NodeGeometry.h"
#include "SegmentationMask.h"
#include "ThrownError.h"

namespace {

using innergs::GridGeometry;
using innergs::Mask;
using innergs::mrml::SegmentationMask;

class SegmentationMaskTest : public SegmentationFixture {
protected:
  /// Slicer's own result on this thread.
  Mask slicers(vtkMRMLSegmentationNode* of, const std::string& segment) {
    vtkNew<vtkOrientedImageData> labels;
    EXPECT_TRUE(segment.empty() ? of->GenerateMergedLabelmapForAllSegments(labels)
                                : of->GetBinaryLabelmapRepresentation(segment, labels));
    vtkNew<vtkMatrix4x4> nodeToWorld, toNode, toWorld;
    innergs::mrml::toWorld(node, nodeToWorld);
    labels->GetImageToWorldMatrix(toNode);
    vtkMatrix4x4::Multiply4x4(nodeToWorld, toNode, toWorld);
    const int* e = labels->GetExtent();
    const int size[3] = {e[1] - e[0] + 1, e[3] - e[2] + 1, e[5] - e[4] + 1}, first[3] = {e[0], e[2], e[4]};
    Mask mask{innergs::vtk::gridOf(toWorld, size, first, "Slicer's"), {}};
    for (int k = e[4]; k <= e[5]; ++k)
      for (int j = e[2]; j <= e[3]; ++j)
        for (int i = e[0]; i <= e[1]; ++i)
          mask.voxels.push_back(labels->GetScalarComponentAsDouble(i, j, k, 0) != 0);
    return mask;
  }
  void expectSame(const Mask& mask, const Mask& expected, const GridGeometry& grid) {
    const auto a = innergs::resampleMask(mask, grid), b = innergs::resampleMask(expected, grid);
    const auto count = std::count(b.begin(), b.end(), 1);
    EXPECT_GT(count, 100);
    EXPECT_LT(count, std::ptrdiff_t(b.size()));
    EXPECT_EQ(a, b);
  }

  innergs::mrml::DetachedTasks unstoppable;
};

TEST_F(SegmentationMaskTest, MergesLabelmapsAsSlicerDoes) {
  addLabelmaps();
  vtkNew<vtkMatrix4x4> coarse;
  const double size[3] = {3, 2, 4}, origin[3] = {-20, -15, -18};
  for (int a = 0; a < 3; ++a) {
    coarse->SetElement(a, a, size[a]);
    coarse->SetElement(a, 3, origin[a]);
  }
  int extent[6] = {0, 14, 0, 16, 0, 9};
  const GridGeometry whole = innergs::mrml::gridOf(input);
  const GridGeometry part = innergs::cropped(whole, {6, 7, 5}, {9, 10, 11});
  const double shift[3] = {3, -2, 1}, one[3] = {1, 1, 1};
  for (const bool reference : {false, true}) // which changes the grid that Slicer merges on
    for (const bool moved : {false, true}) {
      SCOPED_TRACE(testing::Message() << "reference " << reference << ", moved " << moved);
      if (reference)
        segments->SetConversionParameter(vtkSegmentationConverter::GetReferenceImageGeometryParameterName(),
                                         vtkSegmentationConverter::SerializeImageGeometry(coarse, extent));
      node->SetAndObserveTransformNodeID(moved ? addTransform(oblique(15, one, shift))->GetID() : nullptr);
      for (const std::string segment : {"One", "Two", "Turned"}) {
        expectSame(SegmentationMask(node, segment, input, {whole}).make({}, unstoppable),
                   slicers(node, segment), whole);
        expectSame(SegmentationMask(node, segment, input, {part}).make({}, unstoppable),
                   slicers(node, segment), part);
      }
      // Slicer gives up merging if a segment without a voxel is on another grid.
      vtkNew<vtkMRMLSegmentationNode> without;
      without->GetSegmentation()->DeepCopy(segments);
      without->GetSegmentation()->RemoveSegment("Blank");
      const Mask expected = slicers(without, "");
      expectSame(SegmentationMask(node, "", input, {whole}).make({}, unstoppable), expected, whole);
      expectSame(SegmentationMask(node, "", input, {part}).make({}, unstoppable), expected, part);
      expectSame(SegmentationMask(node, "", input, {part, whole}).make({}, unstoppable), expected, whole);
    }
}

TEST_F(SegmentationMaskTest, OfOverlappingSegmentsTheLastOneWins) {
  const auto matrix = matrixOf(input);
  const int whole[6] = {2, 19, 1, 18, 0, 17};
  auto outer = balls(matrix, whole, VTK_SHORT, {{-8, 0, 0, 6}, {8, 0, 0, 6}}); // one layer of two segments
  addSegment("First", outer, 1);
  addSegment("Second", balls(matrix, whole, VTK_SHORT, {{0, 0, 0, 6}}), 1);
  addSegment("Third", outer, 2);
  const auto labels =
      SegmentationMask(node, "", input, {innergs::mrml::gridOf(input)}).makeLabels({}, unstoppable);
  const auto toIndex = innergs::inverse(labels.geometry.indexToWorld());
  const auto labelAt = [&](double r) { // on the axis through the balls, RAS mm
    const auto at = toIndex({-r, 0, 0});
    const auto& n = labels.geometry.size;
    return labels.voxels[std::llround(at[0]) + n[0] * (std::llround(at[1]) + n[1] * std::llround(at[2]))];
  };
  EXPECT_EQ(labelAt(-10), 1);
  EXPECT_EQ(labelAt(-4), 2);
  EXPECT_EQ(labelAt(0), 2);
  EXPECT_EQ(labelAt(4), 3);
  EXPECT_EQ(labelAt(10), 3);
}

TEST_F(SegmentationMaskTest, MakesVoxelsOfSurfacesAsSlicerDoes) {
  addSurface("Left", -7, 9);
  addSurface("Right", 8, 7);
  const GridGeometry whole = innergs::mrml::gridOf(input);
  vtkNew<vtkMRMLSegmentationNode> voxelised;
  voxelised->GetSegmentation()->DeepCopy(segments);
  const auto matrix = matrixOf(input);
  voxelised->GetSegmentation()->SetConversionParameter(
      vtkSegmentationConverter::GetReferenceImageGeometryParameterName(),
      vtkSegmentationConverter::SerializeImageGeometry(matrix, input->GetImageData()));
  ASSERT_TRUE(voxelised->GetSegmentation()->CreateRepresentation(kLabelmap));
  for (const std::string segment : {"", "Left", "Right"})
    expectSame(SegmentationMask(node, segment, input, {whole}).make({}, unstoppable),
               slicers(voxelised, segment), whole);
  EXPECT_FALSE(segments->ContainsRepresentation(kLabelmap)); // it is unchanged
}

TEST_F(SegmentationMaskTest, CropsToWhatTheFitLooksAt) {
  const auto matrix = matrixOf(input);
  const int large[6] = {-60, 80, -60, 80, -60, 80};
  addSegment("Far", balls(matrix, large, VTK_UNSIGNED_CHAR, {{100, 100, 100, 30}}));
  const GridGeometry whole = innergs::mrml::gridOf(input);
  const Mask mask = SegmentationMask(node, "", input, {whole}).make({}, unstoppable);
  EXPECT_LE(mask.geometry.voxelCount(), 32 * 30 * 28);
  EXPECT_EQ(std::count(mask.voxels.begin(), mask.voxels.end(), 1), 0);
}

TEST_F(SegmentationMaskTest, Cancel) {
  std::stop_source stop;
  stop.request_stop();
  const GridGeometry whole = innergs::mrml::gridOf(input);
  const auto expectStopped = [&](const std::string& segment) {
    SegmentationMask mask(node, segment, input, {whole});
    EXPECT_EQ(innergs::test::codeOf([&] { mask.make(stop.get_token(), unstoppable); }),
              innergs::ErrorCode::Cancelled);
  };
  addSurface("Ball", 2, 12);
  expectStopped("");
  expectStopped("Ball");
  EXPECT_TRUE(WatchedRule::threads.empty());
  segments->RemoveAllSegments();
  segments->SetSourceRepresentationName(kLabelmap);
  addLabelmaps();
  expectStopped("");
  expectStopped("One");
}

} // namespace
