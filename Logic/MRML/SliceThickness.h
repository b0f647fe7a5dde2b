#pragma once
#include "vtkSlicerInnerGSLogic.h"

namespace innergs::mrml {

/// Slice thickness (mm) from the DICOM files that a volume was read from, one file per slice along K; 0 if
/// unknown: no lookup, no such volume, slices that do not match the files, or no positive number there.
double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup);

} // namespace innergs::mrml
