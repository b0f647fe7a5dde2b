#pragma once
#include "Evaluation/Protocols.h"

class vtkMRMLTableNode;

namespace innergs::mrml {

/// One row per method (Gaussians, linear, cubic, Lanczos): PSNR in dB, SSIM, seconds; what they were scored
/// on in the attributes InnerGS.Protocol, InnerGS.Samples and InnerGS.Range.
void fillQualityTable(vtkMRMLTableNode* node, const EvaluationReport& report);

} // namespace innergs::mrml
