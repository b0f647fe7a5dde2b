#pragma once
#include "vtkSlicerInnerGSLogic.h"

namespace innergs::mrml {

/// Slice thickness (mm) from the DICOM files that a volume was read from, one file per slice along K; 0 if
/// unknown: no lookup, no such volume, slices that do not match the files, or no positive number there.
double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup);

/// The same from the BIDS file beside the NIfTI that a volume was read from or saved to; 0 if unknown.
double bidsSliceThickness(vtkMRMLVolumeNode* volume);

} // namespace innergs::mrml
