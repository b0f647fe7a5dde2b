#pragma once
#include "Core/Image/Volume.h"

#include <stop_token>
#include <string>

class vtkImageData;
class vtkInformation;

namespace innergs::vtk {

/// A block of an image's voxels: `size` voxels starting at `first` (counted from the image's first voxel
/// along I, J, K), with the axis `sliceAxis` moved to K as in withSliceAxis().
struct VoxelBlock {
  std::array<std::int64_t, 3> first, size;
  int sliceAxis = 2;
};

/// Throws Error(NoData) if there are no voxels, Error(UnsupportedImage) for several components. `what` names
/// the image in the message.
void checkVoxels(vtkImageData* image, const std::string& what);

/// The block's scalars of any numeric type, as the only copy made of them. Throws like checkVoxels(),
/// Error(UnsupportedImage) for a non-numeric type, Error(Cancelled).
std::vector<float> voxelsOf(vtkImageData* image, const VoxelBlock& block, const std::string& what,
                            const std::stop_token& stop = {});
/// The components of an image of several values per voxel, each in memory order. Throws likewise, but for the
/// number of components.
std::vector<std::vector<float>> componentsOf(vtkImageData* image, const std::string& what,
                                             const std::stop_token& stop = {});
/// All scalars in memory order: 1 where non-zero.
std::vector<std::uint8_t> maskOf(vtkImageData* image, const std::string& what,
                                 const std::stop_token& stop = {});

/// Gives an image the size and position of the grid and uninitialised float scalars, and returns them.
float* allocateFloats(vtkImageData* image, const GridGeometry& geometry, bool withGeometry,
                      int components = 1);

/// Announces such an image in a pipeline's output information.
void announceImage(vtkInformation* output, const GridGeometry& geometry, bool withGeometry);

} // namespace innergs::vtk
