#pragma once
#include "Evaluation/Protocols.h"

#include <span>

namespace innergs {

/// Tables for people and programs; held-out reports come first whatever the order given.

std::string textReport(std::span<const EvaluationReport> reports);

/// One row per method and plane: protocol,case,method,plane,psnr,ssim,pooled_psnr,seconds,voxels,samples.
std::string csvReport(std::span<const EvaluationReport> reports);

/// {"protocol", "case", "samples", "peak", "voxels", "methods": {name: {"psnr", "ssim", "seconds",
/// "per_plane"}}, "notes"}; several reports give an array of these. A PSNR that is not finite is null.
std::string jsonReport(std::span<const EvaluationReport> reports);

} // namespace innergs
