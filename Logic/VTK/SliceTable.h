#pragma once
#include "Core/Job/FoundSlices.h"

#include <vtkSmartPointer.h>

#include <span>

class vtkTable;

namespace innergs::vtk {

/// One row per slice: Scan (from 1), Slice (from 0), Weight, Gain, Displacement (mm), Angle (degrees),
/// Residual (scan's units; NaN: unknown), and M00 to M23: the rigid map in RAS mm from where the scan's
/// header puts the slice to where it was found to lie.
vtkSmartPointer<vtkTable> makeSliceTable(std::span<const FoundSlice> found);

} // namespace innergs::vtk
