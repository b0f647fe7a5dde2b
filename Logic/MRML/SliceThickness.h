#pragma once
#include "vtkSlicerInnerGSLogic.h"

namespace innergs::mrml {

/// Slice thickness in mm of the DICOM files that a volume was read from, one file a slice along K; 0 when
/// unknown: no lookup, no such volume, other slices than the files', or no positive number there.
double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup);

} // namespace innergs::mrml
