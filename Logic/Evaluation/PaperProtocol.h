#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// For a method with one value per point, the three planes' stacks of one grid are a single stack: a voxel
/// is observed unless all three planes hold it out. perPlane: three stacks instead (axial, coronal,
/// sagittal), each without its own held-out slices, for methods whose image depends on the slicing direction.
EvaluationInput paperInput(const Volume& volume, double heldOutFraction, std::uint64_t seed,
                           bool perPlane = false);

/// The settings of a fit that the protocol judges: without the residual grid, which would hold the very
/// voxels that the other planes show.
Settings withoutResidualGrid(Settings settings);

/// Throws Error(InvalidArgument) if the volume is too small, NoData if it is constant.
/// Alpha blending is fitted to the planes' own stacks and scored on each, rendered along it.
EvaluationReport evaluatePaper(const Volume& volume, const EvaluationOptions& options = {});

} // namespace innergs
