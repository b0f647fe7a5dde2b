#pragma once
#include "CLI/Picture.h"
#include "Evaluation/Protocols.h"

namespace innergs::cli {

/// The middle axial, coronal and sagittal slice (rows) of the input, the Gaussians, the truth, and the errors
/// of the Gaussians and of the best other method (columns), in radiological orientation. The report must hold
/// its volumes.
Picture comparisonPicture(const EvaluationReport& report, const std::string& title);

} // namespace innergs::cli
