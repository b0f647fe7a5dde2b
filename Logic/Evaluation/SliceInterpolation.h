#pragma once
#include "Evaluation/Baselines.h"

namespace innergs {

/// Weights of the kept slices (ascending indices, at least two) for the slice at index `target`. Linear:
/// between its neighbours; Cubic: natural cubic spline through all kept slices; Lanczos: as if the kept
/// slices were evenly spaced. Beyond the outermost kept slice: that slice.
std::vector<double> sliceWeights(const std::vector<std::int64_t>& kept, std::int64_t target,
                                 Interpolation kind);

/// The volume with each slice in `heldOut`, along grid axis `axis`, interpolated from the other slices of
/// that axis.
Volume interpolateSlices(const Volume& volume, int axis, const std::vector<std::int64_t>& heldOut,
                         Interpolation kind);

} // namespace innergs
