#pragma once
#include "Core/Job/ReconstructionJob.h"

#include <vtkSmartPointer.h>

class vtkTable;

namespace innergs::vtk {

/// One row per slice: Scan (from 1), Slice (from 0), Weight, Gain, Displacement (mm), Angle (degrees),
/// Residual (scan's units; NaN: unknown), and M00 to M23: the rigid map in RAS mm from where the scan's
/// header puts the slice to where it was found to lie. No rows where slices were not looked at one by one.
vtkSmartPointer<vtkTable> makeSliceTable(const ReconstructionResult& result);

} // namespace innergs::vtk
