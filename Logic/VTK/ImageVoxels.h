#pragma once
#include "Core/Volume.h"

#include <stop_token>
#include <string>

class vtkImageData;
class vtkInformation;

namespace innergs::vtk {

/// The scalars of an image of any numeric type, copied in memory order. `what` names it in the sentence.
/// Throws Error(NoData) without voxels, Error(UnsupportedImage) for several components or a type that is no
/// number, Error(Cancelled).
std::vector<float> voxelsOf(vtkImageData* image, const std::string& what, const std::stop_token& stop = {});
/// The same, 1 where not 0.
std::vector<std::uint8_t> maskOf(vtkImageData* image, const std::string& what,
                                 const std::stop_token& stop = {});

/// Gives an image the size and position of the grid and uninitialised float scalars, and returns them.
float* allocateFloats(vtkImageData* image, const GridGeometry& geometry, bool withGeometry);

/// Announces such an image in a pipeline's output information.
void announceImage(vtkInformation* output, const GridGeometry& geometry, bool withGeometry);

} // namespace innergs::vtk
