#include "ReconstructInputs.h"

#include "Core/Base/Error.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"
#include "ImageVoxels.h"

#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cmath>

namespace innergs::vtk {
namespace {

GridGeometry outputGrid(const std::vector<GridGeometry>& grids, const std::vector<Stack>& posed,
                        const OutputChoice& choice) {
  std::vector<Stack> stacks(grids.size());
  for (std::size_t i = 0; i < grids.size(); ++i) {
    stacks[i].image.geometry = posed[i].poses.empty() ? grids[i] : posed[i].image.geometry;
    stacks[i].poses = posed[i].poses;
    stacks[i].thickness = posed[i].thickness;
  }
  GridGeometry grid;
  const Vec3& spacing = choice.spacing;
  if (choice.reference && choice.reference->given()) {
    grid = choice.reference->grid();
  } else if (spacing != Vec3{0, 0, 0}) {
    grid = withSpacing(acquisitionGrid(stacks), spacing);
  } else {
    const bool any = std::any_of(stacks.begin(), stacks.end(), [](const Stack& s) { return !s.poses.empty(); });
    grid = any ? dataDomain(stacks) : defaultOutputGrid(stacks);
  }
  return choice.box && !(choice.reference && choice.reference->given()) ? cropped(grid, *choice.box) : grid;
}

/// The poses of an input (RAS) in LPS.
std::vector<Affine3> posesOf(vtkDoubleArray* given, std::int64_t slices, const std::string& name) {
  std::vector<Affine3> poses;
  if (!given) return poses;
  if (given->GetNumberOfComponents() != 16 || given->GetNumberOfTuples() != slices)
    throw Error(ErrorCode::InvalidArgument, name + " has slice poses of another kind or number than its " +
                                                std::to_string(slices) +
                                                " slices: give 16 components for each.");
  const Mat3 turn = diagonal({-1, -1, 1});
  for (vtkIdType k = 0; k < given->GetNumberOfTuples(); ++k) {
    vtkNew<vtkMatrix4x4> matrix;
    given->GetTuple(k, matrix->GetData());
    const Affine3 ras = affineOf(matrix, "A slice pose of " + name);
    poses.push_back({turn * ras.linear * turn, turn * ras.offset});
  }
  return poses;
}

/// The block of a grid that was cropped to `part`.
VoxelBlock blockOf(const GridGeometry& whole, const GridGeometry& part, int sliceAxis) {
  const Vec3 first = inverse(whole.indexToWorld())(part.origin);
  VoxelBlock block{{}, {}, sliceAxis};
  const std::array<int, 3> from = axesWithSliceAxis(sliceAxis);
  for (int a = 0; a < 3; ++a) {
    block.first[from[a]] = std::llround(first[a]);
    block.size[from[a]] = part.size[a];
  }
  return block;
}

/// Excludes the corners between an oriented box and its block from the fit.
void observeWithin(Stack& stack, const GridGeometry& box, const std::stop_token& stop) {
  stack.observed = resampleMask({box, {1}}, stack.image.geometry, stop);
  if (std::find(stack.observed.begin(), stack.observed.end(), 1) == stack.observed.end())
    throw Error(ErrorCode::Geometry,
                stack.name + " has no voxel inside the region: place the region over the images.");
}

} // namespace

GridGeometry boxOf(const double bounds[6], vtkMatrix4x4* toRAS) {
  vtkNew<vtkMatrix4x4> placed, frame;
  for (int a = 0; a < 3; ++a) {
    const double low = bounds[2 * a], high = bounds[2 * a + 1];
    if (!std::isfinite(low) || !std::isfinite(high) || low >= high)
      throw Error(ErrorCode::InvalidArgument,
                  "The region must have finite bounds, the lower below the upper along every axis.");
    frame->SetElement(a, a, high - low);
    frame->SetElement(a, 3, 0.5 * (low + high));
  }
  if (toRAS)
    vtkMatrix4x4::Multiply4x4(toRAS, frame, placed);
  else
    placed->DeepCopy(frame);
  const int one[3] = {1, 1, 1}, first[3] = {0, 0, 0};
  return gridOf(placed, one, first, "the region");
}

ReconstructInputs::Input* ReconstructInputs::at(int index) {
  if (index < 0 || index > 65535) return nullptr;
  if (static_cast<std::size_t>(index) >= inputs_.size()) inputs_.resize(static_cast<std::size_t>(index) + 1);
  return &inputs_[static_cast<std::size_t>(index)];
}

ReconstructInputs::Input ReconstructInputs::get(int index) const {
  return index >= 0 && static_cast<std::size_t>(index) < inputs_.size()
             ? inputs_[static_cast<std::size_t>(index)]
             : Input{};
}

std::string ReconstructInputs::what(std::size_t index) const {
  const std::string name = get(static_cast<int>(index)).name;
  return name.empty() ? "Input " + std::to_string(index + 1) : name;
}

void ReconstructInputs::check(const Input& options, const std::string& name) {
  if (options.profile < 0 || options.profile > 2)
    throw Error(ErrorCode::InvalidArgument, name + " has an unknown slice profile: give 0, 1 or 2.");
  if (options.axis < 0 || options.axis > 2)
    throw Error(ErrorCode::InvalidArgument,
                name + " has an unknown slice axis: give 0, 1 or 2 for I, J or K.");
}

ReconstructionInput ReconstructInputs::make(const std::vector<vtkImageData*>& images,
                                            const OutputChoice& choice, bool voxels,
                                            const std::stop_token& stop) const {
  if (images.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no image to reconstruct from: give at least one.");
  ReconstructionInput input;
  std::vector<GridGeometry> grids;
  double margin = 0; // mm around the box, so that the fit is as good at its faces
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Input options = get(static_cast<int>(i));
    const std::string name = what(i);
    check(options, name);
    if (voxels) checkVoxels(images[i], name); // first: an image without voxels has no grid either
    grids.push_back(gridOf(images[i], options.ijkToRAS, name));
    Stack stack;
    stack.name = name;
    stack.thickness = options.thickness;
    stack.profile = static_cast<SliceProfile>(options.profile);
    stack.image.geometry = withSliceAxis(grids.back(), options.axis);
    stack.poses = posesOf(options.poses, stack.image.geometry.size[2], name);
    checkThickness(stack.thickness, stack.image.geometry, name, !stack.poses.empty());
    margin = std::max({margin, 2 * stack.thickness, 2 * stack.image.geometry.spacing[2]});
    input.stacks.push_back(std::move(stack));
  }
  input.outputGrid = outputGrid(grids, input.stacks, choice);
  input.cropToMask = !choice.box && !(choice.reference && choice.reference->given());
  for (std::size_t i = 0; i < images.size(); ++i) {
    Stack& stack = input.stacks[i];
    const GridGeometry whole = stack.image.geometry;
    if (choice.box && stack.poses.empty()) {
      stack.image.geometry = cropped(whole, *choice.box, margin);
      stack.isRegion = stack.image.geometry.size != whole.size;
    }
    if (!voxels) continue;
    const VoxelBlock block = blockOf(whole, stack.image.geometry, get(static_cast<int>(i)).axis);
    stack.image.voxels = voxelsOf(images[i], block, stack.name, stop);
    if (choice.box && stack.poses.empty() && !parallel(whole, *choice.box))
      observeWithin(stack, grown(*choice.box, margin), stop);
  }
  return input;
}

ReconstructionInput ReconstructInputs::read(const std::vector<vtkImageData*>& images,
                                            const std::vector<vtkImageData*>& masks,
                                            const OutputChoice& choice, const std::stop_token& stop) const {
  ReconstructionInput input = make(images, choice, true, stop);
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const std::string name = masks.size() == 1 ? "The mask" : "Mask " + std::to_string(m + 1);
    std::vector<std::uint8_t> inside = maskOf(masks[m], name, stop);
    input.masks.push_back(
        {gridOf(masks[m], m < masksToRAS.size() ? masksToRAS[m].Get() : nullptr, name), std::move(inside)});
  }
  return input;
}

ReconstructionInput ReconstructInputs::outline(const std::vector<vtkImageData*>& images,
                                               const OutputChoice& choice) const {
  return make(images, choice, false, {});
}

bool assignCopy(vtkSmartPointer<vtkMatrix4x4>& target, vtkMatrix4x4* source) {
  if (!source) {
    const bool changed = target != nullptr;
    target = nullptr;
    return changed;
  }
  bool same = target != nullptr;
  for (int i = 0; same && i < 16; ++i)
    same = target->GetElement(i / 4, i % 4) == source->GetElement(i / 4, i % 4);
  if (same) return false;
  target = vtkSmartPointer<vtkMatrix4x4>::New();
  target->DeepCopy(source);
  return true;
}

void placeAsAnnounced(vtkInformation* information, vtkImageData* image) {
  if (information->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    image->SetExtent(information->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()));
  if (information->Has(vtkDataObject::ORIGIN())) image->SetOrigin(information->Get(vtkDataObject::ORIGIN()));
  if (information->Has(vtkDataObject::SPACING()))
    image->SetSpacing(information->Get(vtkDataObject::SPACING()));
  if (information->Has(vtkDataObject::DIRECTION()))
    image->SetDirectionMatrix(information->Get(vtkDataObject::DIRECTION()));
}

} // namespace innergs::vtk
