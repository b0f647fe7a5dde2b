#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Uncertainty/Uncertainty.h"

#include <vtkSmartPointer.h>

#include <span>

class vtkImageData;
class vtkMatrix4x4;

namespace innergs::vtk {

/// Fills the image with an uncertainty: scalars "StandardDeviation" (float, scanner units) and point data
/// "Measured" (unsigned char, 0 where no slice measured anything).
void setUncertainty(vtkImageData* image, const Uncertainty& uncertainty, bool withGeometry);

/// Adds these point data to an image with the same number of voxels.
void setMeasured(vtkImageData* image, std::span<const std::uint8_t> measured);

/// These point data as a labelmap (0, 1) with the same voxels, to keep in a file. Throws Error(NoData) for an
/// image without them.
vtkSmartPointer<vtkImageData> measuredLabelmap(vtkImageData* image);

/// Adds them again to an image that lost them in a file. Ignores a labelmap that is null or of another size.
void restoreMeasured(vtkImageData* image, vtkImageData* labelmap);

/// The value that one voxel in a hundred exceeds, above 0: the upper end of a display window for such an
/// image.
double usualDeviation(vtkImageData* image);

/// Samples such an image at points (LPS mm), one per pixel of `plane`: the interpolated deviation, and
/// whether the nearest voxel was measured. Outside the image nothing is measured, and the deviation is the
/// image's largest. ijkToRAS null: from the image's origin, spacing and direction. Throws Error(Geometry |
/// NoData | UnsupportedImage | Cancelled).
void sampleUncertainty(vtkImageData* image, vtkMatrix4x4* ijkToRAS, std::span<const Vec3> points,
                       const GridGeometry& plane, bool withGeometry, ThreadPool& pool, vtkImageData* out);

} // namespace innergs::vtk
