#pragma once
#include "CLI/Picture.h"
#include "Evaluation/Protocols.h"

namespace innergs::cli {

/// Rows: the middle axial, coronal and sagittal slice. Columns: input, Gaussians, truth, and the errors of
/// the Gaussians and of the best other method. In radiological orientation. The report must contain its
/// volumes.
Picture comparisonPicture(const EvaluationReport& report, const std::string& title);

} // namespace innergs::cli
