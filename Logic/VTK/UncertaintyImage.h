#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Uncertainty/Uncertainty.h"

#include <span>

class vtkImageData;
class vtkMatrix4x4;

namespace innergs::vtk {

/// Makes the image that of an uncertainty: scalars "StandardDeviation" (float, scanner units) and point data
/// "Measured" (unsigned char, 0 where no slice measured anything).
void setUncertainty(vtkImageData* image, const Uncertainty& uncertainty, bool withGeometry);

/// Adds that point data to an image of as many voxels.
void setMeasured(vtkImageData* image, std::span<const std::uint8_t> measured);

/// What one voxel in a hundred exceeds: the upper end of a window on such an image, above 0.
double usualDeviation(vtkImageData* image);

/// Such an image at points (LPS mm) into `plane`, which has its size and position: interpolated, and whether
/// the nearest voxel was measured. Beside the image nothing was measured and the deviation is its largest.
/// ijkToRAS null: from the image's origin, spacing and direction. Throws Error(Geometry | NoData |
/// UnsupportedImage | Cancelled).
void sampleUncertainty(vtkImageData* image, vtkMatrix4x4* ijkToRAS, std::span<const Vec3> points,
                       const GridGeometry& plane, bool withGeometry, ThreadPool& pool, vtkImageData* out);

} // namespace innergs::vtk
