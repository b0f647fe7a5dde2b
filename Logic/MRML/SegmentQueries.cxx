#include "SegmentQueries.h"

#include "Core/Base/Error.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "Queries.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkOrientedImageData.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>

#include <algorithm>

namespace innergs::mrml {
namespace {

/// On the whole grid's index axes, as far as the segment reaches.
vtkSmartPointer<vtkOrientedImageData> imageOf(const Segment& segment, vtkMatrix4x4* ijkToRAS) {
  auto image = vtkSmartPointer<vtkOrientedImageData>::New();
  int extent[6] = {0, -1, 0, -1, 0, -1};
  for (int a = 0; a < 3 && !segment.mask.empty(); ++a) {
    extent[2 * a] = static_cast<int>(segment.first[a]);
    extent[2 * a + 1] = static_cast<int>(segment.first[a] + segment.geometry.size[a] - 1);
  }
  image->SetExtent(extent);
  image->SetImageToWorldMatrix(ijkToRAS);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  if (!segment.mask.empty())
    std::copy(segment.mask.begin(), segment.mask.end(),
              static_cast<std::uint8_t*>(image->GetScalarPointer()));
  return image;
}

std::string idOf(vtkSegmentation* segments, const std::string& name) {
  std::vector<std::string> ids;
  segments->GetSegmentIDs(ids);
  for (const std::string& id : ids)
    if (const char* own = segments->GetSegment(id)->GetName(); own && name == own) return id;
  return {};
}

} // namespace

SegmentQueries::SegmentQueries() = default;
SegmentQueries::~SegmentQueries() = default;

SegmentFinder& SegmentQueries::finder(vtkMRMLInnerGSModelNode* model) {
  vtkInnerGSModel* content = modelOf(model);
  if (!finder_ || !model_->HasContentOf(content)) {
    finder_.reset();
    finder_.emplace(content->GetSegmented());
    model_->ShallowCopy(content);
  }
  return *finder_;
}

SegmentFinder& SegmentQueries::encoded(vtkMRMLInnerGSModelNode* model, double spacing) {
  if (!(spacing >= 0)) throw Error(ErrorCode::InvalidArgument, "The spacing must be above 0 mm, or 0.");
  const double mm[3] = {spacing, spacing, spacing};
  SegmentFinder& found = finder(model);
  found.encode(vtk::outputGrid(model_->GetField()->region(), {}, mm));
  return found;
}

SegmentAnswer SegmentQueries::ask(vtkMRMLInnerGSModelNode* model, const std::string& text, double spacing) {
  interpret(Lexicon::standard(), text); // rejects invalid queries before the work starts
  SegmentAnswer found = encoded(model, spacing).find(text);
  answer = found.sentence;
  return found;
}

MadeSegments SegmentQueries::made(vtkMRMLInnerGSModelNode* model, const std::string& text, double spacing,
                                  const SegmentOptions& options) {
  const SegmentAnswer found = ask(model, text, spacing);
  const SegmentFinder& finder = this->finder(model);
  const std::vector<RequestedSegment> requested = finder.requested(text, found);
  if (requested.empty()) throw Error(ErrorCode::NoData, found.sentence);
  return finder.make(requested, options);
}

vtkSmartPointer<vtkMRMLSegmentationNode> addSegments(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                     const MadeSegments& made,
                                                     vtkMRMLSegmentationNode* output) {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> keptModel = model; // observers may remove nodes
  vtkSmartPointer<vtkMRMLSegmentationNode> node = output;
  vtkNew<vtkMatrix4x4> ijkToRAS;
  vtk::toMatrix(made.grid, ijkToRAS);
  if (!node) {
    if (!scene)
      throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add segments to: set one.");
    const std::string name = nameOf(model, "Model") + " segments";
    node = vtkMRMLSegmentationNode::SafeDownCast(addNode(scene, "vtkMRMLSegmentationNode", name));
    if (node->GetScene()) node->CreateDefaultDisplayNodes();
    placeBeside(node, model);
    node->SetAndObserveTransformNodeID(model->GetTransformNodeID());
    vtkNew<vtkOrientedImageData> whole;
    whole->SetExtent(0, static_cast<int>(made.grid.size[0]) - 1, 0, static_cast<int>(made.grid.size[1]) - 1,
                     0, static_cast<int>(made.grid.size[2]) - 1);
    node->GetSegmentation()->SetConversionParameter(
        vtkSegmentationConverter::GetReferenceImageGeometryParameterName(),
        vtkSegmentationConverter::SerializeImageGeometry(ijkToRAS, whole));
  }
  setProvenance(node, model);
  const std::string labelmap = vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName();
  vtkSegmentation* segments = node->GetSegmentation();
  MRMLNodeModifyBlocker blocker(node);
  for (const auto& [terms, segment] : made.segments) {
    vtkNew<vtkSegment> own;
    own->SetName(terms.name.c_str());
    own->SetColor(terms.color[0], terms.color[1], terms.color[2]);
    if (const std::string entry = terminologyEntry(terms); !entry.empty())
      own->SetTag(vtkSegment::GetTerminologyEntryTagName(), entry);
    own->AddRepresentation(labelmap, imageOf(segment, ijkToRAS));
    const std::string before = idOf(segments, terms.name);
    if (!before.empty()) segments->RemoveSegment(before);
    if (!segments->AddSegment(own, before))
      throw Error(ErrorCode::UnsupportedImage, "The segment \"" + terms.name + "\" could not be added to " +
                                                   quoted(node) + ": choose a segmentation of labelmaps.");
  }
  return node;
}

vtkSmartPointer<vtkMRMLScalarVolumeNode> addScore(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                  const MadeSegments& made, vtkMRMLScalarVolumeNode* output) {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> keptModel = model; // observers may remove nodes
  vtkNew<vtkImageData> image;
  float* score = vtk::allocateFloats(image, made.grid, false);
  std::fill_n(score, made.grid.voxelCount(), 0.f);
  for (const auto& [terms, segment] : made.segments)
    forEachVoxel(segment, made.grid.size, [score, &found = segment](std::size_t voxel, std::size_t part) {
      score[voxel] = std::max(score[voxel], found.probability[part]);
    });
  vtkNew<vtkMatrix4x4> ijkToRAS;
  vtk::toMatrix(made.grid, ijkToRAS);
  auto volume = volumeFor(scene, output, model, " score");
  setProvenance(volume, model);
  setVolume(volume, image, ijkToRAS);
  volume->SetAndObserveTransformNodeID(model->GetTransformNodeID());
  return volume;
}

} // namespace innergs::mrml
