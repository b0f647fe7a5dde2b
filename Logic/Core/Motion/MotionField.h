#pragma once
#include "Core/Motion/DynamicField.h"

#include <stop_token>

namespace innergs {

/// How the tissue moves between two times (s), as ITK's displacement fields have it: what lies at voxel
/// centre x at `from` lies at x + d(x) at `to`. So the volume at `to`, resampled through the field (each
/// voxel gets the value at x + d(x)), becomes the volume at `from`. Three values per voxel: mm, LPS. The
/// Gaussians' own small displacements beside the grid's are left out. Throws Error(InvalidArgument) for a
/// field whose Gaussians do not move and for times that are not finite, Error(Cancelled).
std::vector<float> motionField(const DynamicField& field, double from, double to,
                               const GridGeometry& geometry, int threads = 0,
                               const std::stop_token& stop = {});

/// The time (s) of the frame in the middle, where the canonical Gaussians were fitted: the usual `from`.
double middleTime(const DynamicField& field);

} // namespace innergs
