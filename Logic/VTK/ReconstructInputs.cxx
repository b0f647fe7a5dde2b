#include "ReconstructInputs.h"

#include "Core/Error.h"
#include "Core/JobInput.h"
#include "ImageVoxels.h"

#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cmath>

namespace innergs::vtk {
namespace {

/// withSliceAxis() of a lattice alone.
GridGeometry slicedAlong(const GridGeometry& g, int axis) {
  if (axis == 2) return g;
  const std::array<int, 3> from = axis == 0 ? std::array{1, 2, 0} : std::array{0, 2, 1};
  GridGeometry result;
  result.origin = g.origin;
  for (int a = 0; a < 3; ++a) {
    result.size[a] = g.size[from[a]];
    result.spacing[a] = g.spacing[from[a]];
    for (int r = 0; r < 3; ++r)
      result.direction[r][a] = g.direction[r][from[a]];
  }
  return result;
}

GridGeometry outputGrid(const std::vector<GridGeometry>& grids, const OutputChoice& choice) {
  GridGeometry grid;
  const Vec3& spacing = choice.spacing;
  if (choice.reference && choice.reference->given()) {
    grid = choice.reference->grid();
  } else if (spacing != Vec3{0, 0, 0}) {
    for (const double s : spacing)
      if (!std::isfinite(s) || s <= 0)
        throw Error(
            ErrorCode::InvalidArgument,
            "The output spacing must be above 0 mm along every axis, or 0 along all for the default.");
    for (int a = 0; a < 3; ++a)
      if (grids.front().extent()[a] / spacing[a] > 1e5)
        throw Error(ErrorCode::InvalidArgument,
                    "The output spacing is far too fine for the size of the image: choose a coarser one.");
    grid = withSpacing(grids.front(), spacing);
  } else {
    std::vector<Stack> stacks(grids.size());
    for (std::size_t i = 0; i < grids.size(); ++i)
      stacks[i].image.geometry = grids[i];
    grid = defaultOutputGrid(stacks);
  }
  return choice.region && !(choice.reference && choice.reference->given()) ? cropped(grid, *choice.region)
                                                                           : grid;
}

} // namespace

Region regionOf(const double bounds[6]) {
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(bounds[2 * a]) || !std::isfinite(bounds[2 * a + 1]) ||
        bounds[2 * a] >= bounds[2 * a + 1])
      throw Error(ErrorCode::InvalidArgument,
                  "The region must have finite bounds, the lower below the upper along every axis.");
  return {{-bounds[1], -bounds[3], bounds[4]}, {-bounds[0], -bounds[2], bounds[5]}};
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

ReconstructionInput ReconstructInputs::make(const std::vector<vtkImageData*>& images,
                                            const OutputChoice& choice, bool voxels,
                                            const std::stop_token& stop) const {
  if (images.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no image to reconstruct from: give at least one.");
  ReconstructionInput input;
  std::vector<GridGeometry> grids;
  double margin = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Input options = get(static_cast<int>(i));
    const std::string name = what(i);
    if (!std::isfinite(options.thickness) || options.thickness < 0)
      throw Error(ErrorCode::InvalidArgument,
                  name + " has a slice thickness that is negative or not finite: give it in mm, or 0 for the "
                         "distance between slices.");
    if (options.profile < 0 || options.profile > 2)
      throw Error(ErrorCode::InvalidArgument, name + " has an unknown slice profile: give 0, 1 or 2.");
    if (options.axis < 0 || options.axis > 2)
      throw Error(ErrorCode::InvalidArgument,
                  name + " has an unknown slice axis: give 0, 1 or 2 for I, J or K.");
    Stack stack;
    stack.name = name;
    stack.thickness = options.thickness;
    stack.profile = static_cast<SliceProfile>(options.profile);
    std::vector<float> values; // first: an image without voxels has no grid either
    if (voxels) values = voxelsOf(images[i], name, stop);
    grids.push_back(gridOf(images[i], options.ijkToRAS, name));
    stack.image = {grids.back(), std::move(values)};
    if (voxels && options.axis != 2)
      stack.image = withSliceAxis(stack.image, options.axis);
    else
      stack.image.geometry = slicedAlong(grids.back(), options.axis);
    margin = std::max({margin, 2 * stack.thickness, 2 * stack.image.geometry.spacing[2]});
    input.stacks.push_back(std::move(stack));
  }
  input.outputGrid = outputGrid(grids, choice);
  if (choice.region)
    for (Stack& stack : input.stacks) {
      if (voxels)
        stack = cropped(stack, *choice.region, margin);
      else
        stack.image.geometry = cropped(stack.image.geometry, *choice.region, margin);
    }
  return input;
}

ReconstructionInput ReconstructInputs::read(const std::vector<vtkImageData*>& images, vtkImageData* mask,
                                            const OutputChoice& choice, const std::stop_token& stop) const {
  ReconstructionInput input = make(images, choice, true, stop);
  if (mask) {
    std::vector<std::uint8_t> inside = maskOf(mask, "The mask", stop);
    input.mask = Mask{gridOf(mask, maskToRAS, "The mask"), std::move(inside)};
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
