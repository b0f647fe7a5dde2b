#pragma once
#include "Evaluation/Protocols.h"

#include <vtkSmartPointer.h>

class vtkMRMLTableNode;
class vtkTable;

namespace innergs::mrml {

/// One row per method (Gaussians, linear, cubic, Lanczos): PSNR in dB, SSIM, seconds.
vtkSmartPointer<vtkTable> makeQualityTable(const EvaluationReport& report);
/// Puts the table into a node, and the samples that it is for into the attributes InnerGS.Protocol,
/// InnerGS.Samples and InnerGS.Range.
void setQuality(vtkMRMLTableNode* node, vtkTable* table, const EvaluationReport& report);

} // namespace innergs::mrml
