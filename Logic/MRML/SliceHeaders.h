#pragma once
#include "vtkSlicerInnerGSLogic.h"

#include <vector>

/// What the files that a volume was read from say of its slices along K.
namespace innergs::mrml {

/// Slice thickness (mm) from DICOM files, one per slice; 0 if unknown: no lookup, no such volume, slices that
/// do not match the files, or no positive number there.
double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup);

/// The same from the BIDS file beside the NIfTI that a volume was read from or saved to; 0 if unknown.
double bidsSliceThickness(vtkMRMLVolumeNode* volume);

/// When each slice was acquired (s) by DICOM files, one per slice, of which each is looked up; empty if
/// unknown.
std::vector<double> dicomSliceTimes(vtkMRMLVolumeNode* volume,
                                    const vtkSlicerInnerGSLogic::DicomLookup& lookup);

/// The same from the BIDS file beside the NIfTI that a volume was read from or saved to. Slicer may have
/// reversed the slices.
std::vector<double> bidsSliceTimes(vtkMRMLVolumeNode* volume);

} // namespace innergs::mrml
