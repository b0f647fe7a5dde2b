#include "JobFixture.h"

#include "Core/Error.h"
#include "Geometry.h"
#include "NodeGeometry.h"
#include "SegmentationMask.h"

#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLSegmentationNode.h>

#include <vtkClosedSurfaceToBinaryLabelmapConversionRule.h>
#include <vtkOrientedImageData.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>
#include <vtkSegmentationConverterFactory.h>
#include <vtkSphereSource.h>

#include <atomic>
#include <mutex>
#include <set>

namespace {

using innergs::GridGeometry;
using innergs::Mask;
using innergs::mrml::SegmentationMask;

const std::string kLabelmap = vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName();
const std::string kSurface = vtkSegmentationConverter::GetSegmentationClosedSurfaceRepresentationName();

std::mutex converting;
std::set<std::thread::id> converters; // threads that made voxels of surfaces

/// Slicer's own rule, which also tells on which thread it runs.
class WatchedRule : public vtkClosedSurfaceToBinaryLabelmapConversionRule {
public:
  static WatchedRule* New();
  vtkTypeMacro(WatchedRule, vtkClosedSurfaceToBinaryLabelmapConversionRule);
  vtkSegmentationConverterRule* CreateRuleInstance() override { return WatchedRule::New(); }
  unsigned int GetConversionCost(vtkDataObject*, vtkDataObject*) override { return 1; } // before the other
  bool Convert(vtkSegment* segment) override {
    {
      std::lock_guard lock(converting);
      converters.insert(std::this_thread::get_id());
    }
    return this->Superclass::Convert(segment);
  }
};
vtkStandardNewMacro(WatchedRule);

class SegmentationMaskTest : public MrmlFixture {
protected:
  SegmentationMaskTest() {
    vtkSegmentationConverterFactory::GetInstance()->RegisterConverterRule(rule);
    converters.clear();
    input = addVolume();
    node =
        vtkMRMLSegmentationNode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLSegmentationNode", "Organs"));
    segments = node->GetSegmentation();
  }
  ~SegmentationMaskTest() override {
    vtkSegmentationConverterFactory::GetInstance()->UnregisterConverterRule(rule);
  }

  /// Balls with the labels 1, 2, ... on one lattice.
  static vtkSmartPointer<vtkOrientedImageData>
  balls(vtkMatrix4x4* toNode, const int extent[6], int type,
        const std::vector<std::array<double, 4>>& ballsOfNode) { // centre, radius (mm)
    auto image = vtkSmartPointer<vtkOrientedImageData>::New();
    image->SetExtent(const_cast<int*>(extent));
    image->SetImageToWorldMatrix(toNode);
    image->AllocateScalars(type, 1);
    for (int k = extent[4]; k <= extent[5]; ++k)
      for (int j = extent[2]; j <= extent[3]; ++j)
        for (int i = extent[0]; i <= extent[1]; ++i) {
          double at[4] = {double(i), double(j), double(k), 1};
          toNode->MultiplyPoint(at, at);
          int label = 0;
          for (std::size_t n = 0; n < ballsOfNode.size(); ++n) {
            const auto& b = ballsOfNode[n];
            if (std::hypot(at[0] - b[0], at[1] - b[1], at[2] - b[2]) < b[3]) label = int(n) + 1;
          }
          image->SetScalarComponentFromDouble(i, j, k, 0, label);
        }
    return image;
  }
  void addSegment(const std::string& id, vtkDataObject* data, int label = 1) {
    vtkNew<vtkSegment> segment;
    segment->SetLabelValue(label);
    segment->AddRepresentation(data->IsA("vtkPolyData") ? kSurface : kLabelmap, data);
    ASSERT_TRUE(segments->AddSegment(segment, id));
  }
  void addSurface(const std::string& id, double r, double radius) {
    vtkNew<vtkSphereSource> sphere;
    sphere->SetCenter(r, -2, 3);
    sphere->SetRadius(radius);
    sphere->SetThetaResolution(24);
    sphere->SetPhiResolution(24);
    sphere->Update();
    segments->SetSourceRepresentationName(kSurface);
    addSegment(id, sphere->GetOutput());
  }
  /// Two on one lattice, one on a finer, turned one, one without a voxel.
  void addLabelmaps() {
    vtkNew<vtkMatrix4x4> matrix;
    input->GetIJKToRASMatrix(matrix);
    const int whole[6] = {2, 19, 1, 18, 0, 17};
    auto shared = balls(matrix, whole, VTK_SHORT, {{-6, -4, -5, 8}, {6, 5, -5, 9}});
    const double spacing[3] = {1.1, 0.9, 1.3}, origin[3] = {-5, 2, 4};
    const int part[6] = {-9, 12, -8, 11, -7, 10};
    auto turned = balls(oblique(25, spacing, origin), part, VTK_UNSIGNED_CHAR, {{-2, 4, 6, 8}});
    addSegment("One", shared, 1);
    addSegment("Two", shared, 2);
    addSegment("Turned", turned);
    addSegment("Blank", balls(matrix, whole, VTK_UNSIGNED_CHAR, {}));
    addSegment("Empty", vtkNew<vtkOrientedImageData>());
  }

  /// What Slicer makes of it on this thread.
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

  vtkNew<WatchedRule> rule;
  vtkMRMLScalarVolumeNode* input = nullptr;
  vtkMRMLSegmentationNode* node = nullptr;
  vtkSegmentation* segments = nullptr;
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
  for (const bool reference : {false, true}) // the lattice that Slicer merges on is another then
    for (const bool moved : {false, true}) {
      SCOPED_TRACE(testing::Message() << "reference " << reference << ", moved " << moved);
      if (reference)
        segments->SetConversionParameter(vtkSegmentationConverter::GetReferenceImageGeometryParameterName(),
                                         vtkSegmentationConverter::SerializeImageGeometry(coarse, extent));
      node->SetAndObserveTransformNodeID(moved ? addTransform(oblique(15, one, shift))->GetID() : nullptr);
      for (const std::string segment : {"One", "Two", "Turned"}) {
        expectSame(SegmentationMask(node, segment, input, {whole}).make({}), slicers(node, segment), whole);
        expectSame(SegmentationMask(node, segment, input, {part}).make({}), slicers(node, segment), part);
      }
      // Slicer gives up merging when a segment without a voxel is on another lattice.
      vtkNew<vtkMRMLSegmentationNode> without;
      without->GetSegmentation()->DeepCopy(segments);
      without->GetSegmentation()->RemoveSegment("Blank");
      const Mask expected = slicers(without, "");
      expectSame(SegmentationMask(node, "", input, {whole}).make({}), expected, whole);
      expectSame(SegmentationMask(node, "", input, {part}).make({}), expected, part);
      expectSame(SegmentationMask(node, "", input, {part, whole}).make({}), expected, whole);
    }
}

TEST_F(SegmentationMaskTest, MakesVoxelsOfSurfacesAsSlicerDoes) {
  addSurface("Left", -7, 9);
  addSurface("Right", 8, 7);
  const GridGeometry whole = innergs::mrml::gridOf(input);
  vtkNew<vtkMRMLSegmentationNode> voxelised;
  voxelised->GetSegmentation()->DeepCopy(segments);
  vtkNew<vtkMatrix4x4> matrix;
  input->GetIJKToRASMatrix(matrix);
  voxelised->GetSegmentation()->SetConversionParameter(
      vtkSegmentationConverter::GetReferenceImageGeometryParameterName(),
      vtkSegmentationConverter::SerializeImageGeometry(matrix, input->GetImageData()));
  ASSERT_TRUE(voxelised->GetSegmentation()->CreateRepresentation(kLabelmap));
  for (const std::string segment : {"", "Left", "Right"})
    expectSame(SegmentationMask(node, segment, input, {whole}).make({}), slicers(voxelised, segment), whole);
  EXPECT_FALSE(segments->ContainsRepresentation(kLabelmap)); // it stays as it was
}

// Only copies are made on the main thread: what the work finds out is not known there, and the rules that
// make voxels of surfaces run elsewhere.
TEST_F(SegmentationMaskTest, WorkAndItsErrorsAreTheWorkers) {
  vtkNew<vtkMatrix4x4> matrix;
  input->GetIJKToRASMatrix(matrix);
  const int whole[6] = {2, 19, 1, 18, 0, 17};
  addSegment("Blank", balls(matrix, whole, VTK_UNSIGNED_CHAR, {}));
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(2);
  parameters->SetMaskNode(node);
  for (const bool copy : {true, false}) {
    errors.clear();
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    ASSERT_NE(job, nullptr) << logic->GetLastError();
    ASSERT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
    EXPECT_EQ(job->GetErrorMessage(), "The mask 'Organs' is empty: draw a segment or leave it out.");
    EXPECT_EQ(errors.size(), 1u);
    EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  }
  segments->RemoveAllSegments();
  addSurface("Ball", 0, 12);
  for (const bool copy : {true, false}) {
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    ASSERT_NE(job, nullptr) << logic->GetLastError();
    ASSERT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
  }
  EXPECT_EQ(converters.size(), 1u); // the worker
  EXPECT_EQ(converters.count(std::this_thread::get_id()), 0u);
  EXPECT_FALSE(segments->ContainsRepresentation(kLabelmap));

  // Slicer's labelmap of a surface cannot be made of one that is none.
  segments->RemoveAllSegments();
  addSegment("None", vtkNew<vtkPolyData>());
  vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters);
  ASSERT_NE(job, nullptr) << logic->GetLastError();
  ASSERT_TRUE(logic->WaitForJob(job));
  EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Failed);
  EXPECT_NE(job->GetErrorMessage().find("'Organs' is empty"), std::string::npos) << job->GetErrorMessage();
}

TEST_F(SegmentationMaskTest, EditedOrRemovedAfterTheStart) {
  auto* parameters = addParameters(input);
  parameters->SetNumberOfIterations(5);
  const auto start = [&](bool copy) {
    vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
    EXPECT_NE(job, nullptr) << logic->GetLastError();
    return job;
  };
  const auto resultOf = [&](vtkSlicerInnerGSJob* job) {
    EXPECT_TRUE(logic->WaitForJob(job));
    EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Finished) << job->GetErrorMessage();
    std::vector<float> values;
    if (auto* volume = job->GetVolumeNode()) {
      const auto* first = static_cast<const float*>(volume->GetImageData()->GetScalarPointer());
      values.assign(first, first + volume->GetImageData()->GetNumberOfPoints());
    }
    return values;
  };
  const std::vector<float> unmasked = resultOf(start(true));
  vtkSmartPointer<vtkMRMLSegmentationNode> kept = node; // when it is removed
  const auto fill = [&] {
    if (node->GetScene() != scene.Get()) {
      node = vtkMRMLSegmentationNode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLSegmentationNode"));
    }
    kept = node;
    segments = node->GetSegmentation();
    segments->RemoveAllSegments();
    segments->SetSourceRepresentationName(kLabelmap);
    parameters->SetMaskNode(node);
  };
  for (const bool surfaces : {false, true}) {
    const auto draw = [&] {
      fill();
      if (surfaces)
        addSurface("Ball", 2, 12);
      else
        addLabelmaps();
    };
    draw();
    const std::vector<float> before = resultOf(start(true));
    EXPECT_NE(before, unmasked);
    for (const bool copy : {true, false})
      for (const int edit : {0, 1, 2}) {
        SCOPED_TRACE(testing::Message() << "surfaces " << surfaces << ", copy " << copy << ", edit " << edit);
        draw();
        vtkSmartPointer<vtkSlicerInnerGSJob> job = start(copy);
        if (edit == 0) {
          scene->RemoveNode(node);
        } else if (edit == 1) {
          segments->RemoveAllSegments();
        } else if (surfaces) {
          segments->GetNthSegment(0)->AddRepresentation(kSurface, vtkNew<vtkPolyData>());
        } else { // as the segment editor paints
          auto* image =
              vtkOrientedImageData::SafeDownCast(segments->GetSegment("Two")->GetRepresentation(kLabelmap));
          image->GetPointData()->GetScalars()->Fill(2);
          image->Modified();
        }
        EXPECT_EQ(resultOf(job), before);
      }
  }
  EXPECT_TRUE(errors.empty());
}

TEST_F(SegmentationMaskTest, CropsToWhatTheFitLooksAt) {
  vtkNew<vtkMatrix4x4> matrix;
  input->GetIJKToRASMatrix(matrix);
  const int large[6] = {-60, 80, -60, 80, -60, 80};
  addSegment("Far", balls(matrix, large, VTK_UNSIGNED_CHAR, {{100, 100, 100, 30}}));
  const GridGeometry whole = innergs::mrml::gridOf(input);
  const Mask mask = SegmentationMask(node, "", input, {whole}).make({});
  EXPECT_LE(mask.geometry.voxelCount(), 32 * 30 * 28);
  EXPECT_EQ(std::count(mask.voxels.begin(), mask.voxels.end(), 1), 0);
  auto* parameters = addParameters(input);
  parameters->SetMaskNode(node);
  EXPECT_FALSE(logic->Reconstruct(parameters));
  EXPECT_NE(logic->GetLastError().find("does not cover"), std::string::npos) << logic->GetLastError();
}

TEST_F(SegmentationMaskTest, Cancel) {
  std::stop_source stop;
  stop.request_stop();
  const GridGeometry whole = innergs::mrml::gridOf(input);
  const auto expectStopped = [&](const std::string& segment) {
    SegmentationMask mask(node, segment, input, {whole});
    try {
      mask.make(stop.get_token());
      FAIL();
    } catch (const innergs::Error& error) {
      EXPECT_EQ(error.code(), innergs::ErrorCode::Cancelled);
    }
  };
  addSurface("Ball", 2, 12);
  expectStopped("");
  expectStopped("Ball");
  EXPECT_TRUE(converters.empty());
  segments->RemoveAllSegments();
  segments->SetSourceRepresentationName(kLabelmap);
  addLabelmaps();
  expectStopped("");
  expectStopped("One");
  // In the phase in which it is made, and before.
  auto* parameters = addParameters(input);
  parameters->SetMaskNode(node);
  for (const bool copy : {true, false})
    for (const bool running : {true, false}) {
      vtkSmartPointer<vtkSlicerInnerGSJob> job = logic->StartReconstruction(parameters, copy);
      ASSERT_NE(job, nullptr) << logic->GetLastError();
      while (running && job->GetState() == vtkSlicerInnerGSJob::Queued)
        logic->WaitForJob(job, 0.001);
      logic->Cancel(job);
      EXPECT_EQ(job->GetState(), vtkSlicerInnerGSJob::Cancelled);
      EXPECT_EQ(job->GetErrorMessage(), "");
    }
  EXPECT_EQ(countNodes("vtkMRMLInnerGSModelNode"), 0);
  EXPECT_TRUE(errors.empty());
}

} // namespace
