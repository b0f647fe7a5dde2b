#pragma once
#include "Core/Alignment/BlurredStack.h"

namespace innergs {

/// A grid around all boxes: cubes of `spacing` mm along the first one's axes, with a margin in mm.
GridGeometry gridAround(std::span<const GridGeometry> boxes, double spacing, double margin);

/// The part of each stack's grid with observed voxels; all of it where there are none.
std::vector<GridGeometry> observedBoxes(std::span<const Stack> stacks);
GridGeometry observedBox(const BlurredStack& image);

/// Points spread evenly over a grid's box, about `distance` mm apart, at most 40,000: Roberts'
/// quasi-random sequence (2018) in three dimensions. A regular grid would always sample slices at the same
/// fractions of their distance, and so at another resolution.
std::vector<Vec3> spreadPlaces(const GridGeometry& box, double distance);

/// The range of the finite values.
ValueRange valuesOf(const BlurredStack& image);

/// A value between air and body: halfway from the lowest to foregroundThreshold().
double bodyThreshold(const BlurredStack& image);

/// Whether values have an offset, as in CT: such values must not be scaled.
bool belowZero(const ValueRange& range);

} // namespace innergs
