#include "SegmentationMask.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Image/Bounds.h"
#include "Core/Job/ReconstructionJob.h"
#include "DetachedTasks.h"
#include "Geometry.h"
#include "NodeGeometry.h"

#include <vtkClosedSurfaceToBinaryLabelmapConversionRule.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLVolumeNode.h>
#include <vtkOrientedImageData.h>
#include <vtkOrientedImageDataResample.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>
#include <vtkSegmentationConverterFactory.h>

#include <vtkCallbackCommand.h>
#include <vtkImageReslice.h>
#include <vtkPointData.h>
#include <vtkTransform.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs::mrml {
namespace {

constexpr std::int64_t kBlock = std::int64_t{1} << 21; // voxels between checks of the stop token

std::string labelmapName() {
  return vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName();
}

[[noreturn]] void refuseEmpty(const std::string& name) {
  throw Error(ErrorCode::NoData, name + " is empty: draw a segment in it or choose another.");
}

std::string referenceName() {
  return vtkSegmentationConverter::GetReferenceImageGeometryParameterName();
}

void throwIf(const std::stop_token& stop) {
  throwIfStopped(stop);
}

bool hasVoxels(vtkOrientedImageData* image) {
  return image && !image->IsEmpty() && image->GetPointData()->GetScalars();
}

/// The largest spacing (mm) of the grids that voxels may be resampled on before the fit's own.
double largestStep(vtkSegmentation* segments, const std::vector<std::string>& ids) {
  double step = 0;
  const auto consider = [&](vtkOrientedImageData* image) {
    if (image) step = std::max(step, *std::max_element(image->GetSpacing(), image->GetSpacing() + 3));
  };
  for (const std::string& id : ids)
    consider(vtkOrientedImageData::SafeDownCast(segments->GetSegment(id)->GetRepresentation(labelmapName())));
  if (vtkSegmentationConverterFactory::GetInstance()->GetConverterRules().empty())
    return step; // no parameters
  vtkNew<vtkOrientedImageData> reference;
  const std::string text = segments->GetConversionParameter(referenceName());
  if (!text.empty() && vtkSegmentationConverter::DeserializeImageGeometry(text, reference, false))
    consider(reference);
  return step;
}

/// The image's grid (LPS), and its index → world (RAS).
GridGeometry worldGridOf(vtkOrientedImageData* image, vtkMatrix4x4* nodeToWorld, vtkMatrix4x4* imageToWorld) {
  vtkNew<vtkMatrix4x4> imageToNode;
  image->GetImageToWorldMatrix(imageToNode);
  vtkMatrix4x4::Multiply4x4(nodeToWorld, imageToNode, imageToWorld);
  const int* extent = image->GetExtent();
  const int size[3] = {extent[1] - extent[0] + 1, extent[3] - extent[2] + 1, extent[5] - extent[4] + 1};
  const int first[3] = {extent[0], extent[2], extent[4]};
  return vtk::gridOf(imageToWorld, size, first, "The mask");
}

/// The part of an image's extent that reaches into the grids, a margin (mm) and two voxels around; at least a
/// voxel.
void within(vtkOrientedImageData* image, vtkMatrix4x4* nodeToWorld, const std::vector<GridGeometry>& grids,
            double margin, int part[6]) {
  vtkNew<vtkMatrix4x4> imageToWorld;
  worldGridOf(image, nodeToWorld, imageToWorld); // refuses what is sheared
  const Affine3 toImage = inverse(vtk::affineOf(imageToWorld, "The mask"));
  Bounds box;
  for (const GridGeometry& grid : grids)
    for (const Vec3& corner : grid.corners())
      box.include(toImage(vtk::flipped(corner)));
  int extent[6];
  image->GetExtent(extent);
  for (int a = 0; a < 3; ++a) {
    const double more = 2 + margin / image->GetSpacing()[a];
    const double first = extent[2 * a], last = extent[2 * a + 1];
    part[2 * a] = static_cast<int>(std::clamp(std::floor(box.low[a] - more), first, last));
    part[2 * a + 1] = static_cast<int>(std::clamp(std::ceil(box.high[a] + more), first, last));
  }
}

vtkSmartPointer<vtkOrientedImageData> copyOf(vtkOrientedImageData* image, int part[6]) {
  auto copy = vtkSmartPointer<vtkOrientedImageData>::New();
  if (std::equal(part, part + 6, image->GetExtent())) {
    copy->DeepCopy(image);
    return copy;
  }
  vtkNew<vtkMatrix4x4> toNode;
  image->GetImageToWorldMatrix(toNode);
  copy->SetExtent(part);
  copy->SetImageToWorldMatrix(toNode);
  copy->AllocateScalars(image->GetScalarType(), image->GetNumberOfScalarComponents());
  copy->CopyAndCastFrom(image, part);
  return copy;
}

using Numbers = std::map<double, std::uint16_t>;

/// What a mask (bytes) or labelmap stores for the segment of a value; 0: none.
template <class Label>
Label labelOf(const Numbers& numbers, double value) {
  const auto found = numbers.find(value);
  if (found == numbers.end()) return 0;
  return sizeof(Label) == 1 ? Label{1} : static_cast<Label>(found->second);
}

/// Sets the voxels of a mask or labelmap, which has the extent `whole`, where the image has one of the
/// values.
template <class T, class Label>
void mark(vtkImageData* image, const Numbers& numbers, const int whole[6], std::vector<Label>& mask) {
  int part[6];
  image->GetExtent(part);
  const auto* value = static_cast<const T*>(image->GetScalarPointer());
  const int components = image->GetNumberOfScalarComponents();
  const std::int64_t row = whole[1] - whole[0] + 1, slice = row * (whole[3] - whole[2] + 1);
  T last{};
  auto label = labelOf<Label>(numbers, 0);
  for (int k = part[4]; k <= part[5]; ++k)
    for (int j = part[2]; j <= part[3]; ++j) {
      Label* out = mask.data() + (k - whole[4]) * slice + (j - whole[2]) * row + (part[0] - whole[0]);
      for (int i = part[0]; i <= part[1]; ++i, ++out, value += components) {
        if (*value != last) { // labels come in runs
          last = *value;
          label = labelOf<Label>(numbers, static_cast<double>(last));
        }
        *out = std::max(*out, label); // of overlapping segments, the last
      }
    }
}

/// A layer's segments, looked up on the grid (nearest neighbour).
template <class Label>
void merge(vtkOrientedImageData* layer, const Numbers& numbers, vtkOrientedImageData* grid,
           std::vector<Label>& mask, const std::stop_token& stop) {
  vtkNew<vtkTransform> toLayer, toGrid; // stay the identity where both have the same voxels
  if (!vtkOrientedImageDataResample::DoGeometriesMatch(layer, grid)) {
    vtkNew<vtkMatrix4x4> layerToNode, nodeToLayer, gridToNode, matrix;
    layer->GetImageToWorldMatrix(layerToNode);
    grid->GetImageToWorldMatrix(gridToNode);
    vtkMatrix4x4::Invert(layerToNode, nodeToLayer);
    vtkMatrix4x4::Multiply4x4(nodeToLayer, gridToNode, matrix);
    toLayer->SetMatrix(matrix);
    matrix->Invert();
    toGrid->SetMatrix(matrix);
  }
  int whole[6], part[6], layerExtent[6];
  grid->GetExtent(whole);
  layer->GetExtent(layerExtent);
  vtkOrientedImageDataResample::TransformExtent(layerExtent, toGrid, part);
  for (int a = 0; a < 3; ++a) {
    part[2 * a] = std::max(part[2 * a], whole[2 * a]);
    part[2 * a + 1] = std::min(part[2 * a + 1], whole[2 * a + 1]);
    if (part[2 * a] > part[2 * a + 1]) return;
  }
  vtkNew<vtkImageData> voxels; // in index space: the filter knows no directions
  voxels->ShallowCopy(layer);
  voxels->SetOrigin(0, 0, 0);
  voxels->SetSpacing(1, 1, 1);
  voxels->SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1);
  vtkNew<vtkImageReslice> lookUp;
  lookUp->SetInputData(voxels);
  lookUp->SetResliceTransform(toLayer);
  lookUp->SetInterpolationModeToNearestNeighbor();
  lookUp->SetOutputOrigin(0, 0, 0);
  lookUp->SetOutputSpacing(1, 1, 1);
  const std::int64_t slice = std::int64_t{part[1] - part[0] + 1} * (part[3] - part[2] + 1);
  const int step = static_cast<int>(std::max<std::int64_t>(1, kBlock / slice));
  for (int k = part[4]; k <= part[5]; k += step) {
    throwIf(stop);
    lookUp->SetOutputExtent(part[0], part[1], part[2], part[3], k, std::min(k + step - 1, part[5]));
    lookUp->Update();
    vtkImageData* found = lookUp->GetOutput();
    switch (found->GetScalarType()) { vtkTemplateMacro((mark<VTK_TT, Label>(found, numbers, whole, mask))); }
  }
}

} // namespace

SegmentationMask::SegmentationMask(vtkMRMLSegmentationNode* node, const std::string& segment,
                                   vtkMRMLVolumeNode* like, const std::vector<GridGeometry>& grids,
                                   const std::string& role)
    : name_("The " + role + " " + quoted(node)), single_(!segment.empty()),
      converter_(vtkSmartPointer<vtkSegmentation>::New()) {
  check(node, segment, role);
  vtkSegmentation* segments = node->GetSegmentation();
  toWorld(node, nodeToWorld_);
  merger_->CopyConversionParameters(segments);
  converter_->CopyConversionParameters(segments);
  std::vector<std::string> ids{segment};
  if (!single_) segments->GetSegmentIDs(ids);
  const double margin = largestStep(segments, ids);
  for (const std::string& id : ids) {
    vtkSegment* taken = segments->GetSegment(id);
    names_.emplace_back(taken->GetName() ? taken->GetName() : "");
    const auto number = static_cast<std::uint16_t>(names_.size());
    if (auto* image = vtkOrientedImageData::SafeDownCast(taken->GetRepresentation(labelmapName())))
      takeLabelmap(image, taken->GetLabelValue(), number, grids, margin);
    else
      takeOthers(taken, number);
  }
  copies_.clear();
  if (layers_.empty() && others_.empty()) refuseEmpty(name_);
  if (others_.empty()) return;
  vtkNew<vtkMatrix4x4> worldToNode, likeToWorld, likeToNode;
  vtkMatrix4x4::Invert(nodeToWorld_, worldToNode);
  ijkToWorld(like, likeToWorld);
  vtkMatrix4x4::Multiply4x4(worldToNode, likeToWorld, likeToNode);
  const std::string reference =
      vtkSegmentationConverter::SerializeImageGeometry(likeToNode, like->GetImageData());
  converter_->SetConversionParameter(referenceName(), reference);
  converter_->SetConversionParameter(
      vtkClosedSurfaceToBinaryLabelmapConversionRule::GetCollapseLabelmapsParameterName(), "0");
  if (layers_.empty()) merger_->SetConversionParameter(referenceName(), reference);
}

SegmentationMask::~SegmentationMask() = default;

void SegmentationMask::check(vtkMRMLSegmentationNode* node, const std::string& segment,
                             const std::string& role) {
  vtkSegmentation* segments = node->GetSegmentation();
  if (!segments || segments->GetNumberOfSegments() == 0) refuseEmpty("The " + role + " " + quoted(node));
  if (!segment.empty() && !segments->GetSegment(segment))
    throw Error(ErrorCode::InvalidArgument, "The " + role + " " + quoted(node) +
                                                " has no segment with the ID '" + segment +
                                                "': choose another.");
  toWorld(node, vtkNew<vtkMatrix4x4>());
}

void SegmentationMask::takeLabelmap(vtkOrientedImageData* image, int label, std::uint16_t number,
                                    const std::vector<GridGeometry>& grids, double margin) {
  if (!hasVoxels(image)) return;
  vtkSmartPointer<vtkOrientedImageData>& copy = copies_[image];
  if (!copy) {
    int part[6];
    within(image, nodeToWorld_, grids, margin, part);
    cropped_ = cropped_ || !std::equal(part, part + 6, image->GetExtent());
    copy = copyOf(image, part);
  }
  addLayer(copy, label, number);
}

void SegmentationMask::takeOthers(vtkSegment* segment, std::uint16_t number) {
  std::vector<std::string> names;
  segment->GetContainedRepresentationNames(names);
  if (names.empty()) return;
  vtkNew<vtkSegment> own;
  own->SetName(segment->GetName());
  own->SetLabelValue(segment->GetLabelValue());
  for (const std::string& name : names) {
    vtkDataObject* data = segment->GetRepresentation(name);
    const auto copy = vtkSmartPointer<vtkDataObject>::Take(data->NewInstance());
    copy->DeepCopy(data); // views step through the cells of a surface as well
    own->AddRepresentation(name, copy);
  }
  others_.push_back({own.Get(), number});
}

void SegmentationMask::addLayer(vtkOrientedImageData* image, int label, std::uint16_t number) {
  auto layer = std::find_if(layers_.begin(), layers_.end(), [&](const Layer& l) { return l.image == image; });
  if (layer == layers_.end()) layer = layers_.insert(layers_.end(), {image, {}});
  layer->numbers[label] = number;
}

void SegmentationMask::makeVoxels(const std::stop_token& stop, DetachedTasks& unstoppable) {
  vtkNew<vtkCallbackCommand> quiet; // this file throws its own error
  converter_->AddObserver(vtkCommand::ErrorEvent, quiet);
  for (const auto& [segment, number] : others_) {
    // A segmentation converts what is added to it.
    const auto convert = [segment = segment, converter = converter_] {
      return converter->AddSegment(segment, std::to_string(converter->GetNumberOfSegments()));
    };
    if (!unstoppable.run(convert, stop))
      throw Error(ErrorCode::UnsupportedImage,
                  name_ + " has no voxels, and none could be made of its surfaces: create its binary "
                          "labelmap in the Segmentations module first.");
    auto* image = vtkOrientedImageData::SafeDownCast(segment->GetRepresentation(labelmapName()));
    if (hasVoxels(image)) addLayer(image, segment->GetLabelValue(), number);
  }
  others_.clear();
}

void SegmentationMask::chooseGrid(vtkOrientedImageData* grid) {
  if (single_) {
    grid->ShallowCopy(layers_.front().image);
    return;
  }
  for (std::size_t n = 0; n < layers_.size(); ++n) {
    vtkNew<vtkSegment> segment;
    segment->AddRepresentation(labelmapName(), layers_[n].image);
    merger_->AddSegment(segment, std::to_string(n));
  }
  const std::string geometry =
      merger_->DetermineCommonLabelmapGeometry(vtkSegmentation::EXTENT_UNION_OF_SEGMENTS);
  vtkSegmentationConverter::DeserializeImageGeometry(geometry, grid, false);
}

template <class Label>
GridGeometry SegmentationMask::mergeAll(std::vector<Label>& voxels, const std::stop_token& stop,
                                        DetachedTasks& unstoppable) {
  makeVoxels(stop, unstoppable);
  if (layers_.empty()) refuseEmpty(name_);
  vtkNew<vtkOrientedImageData> grid;
  chooseGrid(grid);
  const GridGeometry geometry = worldGridOf(grid, nodeToWorld_, vtkNew<vtkMatrix4x4>());
  const auto bytes = geometry.voxelCount() * static_cast<std::int64_t>(sizeof(Label));
  if (const std::int64_t available = availableMemory(); available > 0 && bytes > available)
    throw Error(ErrorCode::Memory, name_ +
                                       " has segments whose voxels differ too much in size to be merged in "
                                       "memory: choose one segment, or give all the same voxels in the "
                                       "Segmentations module.");
  voxels.resize(static_cast<std::size_t>(geometry.voxelCount()));
  for (const Layer& layer : std::exchange(layers_, {}))
    merge(layer.image, layer.numbers, grid, voxels, stop);
  if (!cropped_ && std::all_of(voxels.begin(), voxels.end(), [](Label label) { return label == 0; }))
    refuseEmpty(name_);
  return geometry;
}

Mask SegmentationMask::make(const std::stop_token& stop, DetachedTasks& unstoppable) {
  Mask mask;
  mask.geometry = mergeAll(mask.voxels, stop, unstoppable);
  return mask;
}

Labelmap SegmentationMask::makeLabels(const std::stop_token& stop, DetachedTasks& unstoppable) {
  Labelmap labels;
  labels.geometry = mergeAll(labels.voxels, stop, unstoppable);
  return labels;
}

} // namespace innergs::mrml
