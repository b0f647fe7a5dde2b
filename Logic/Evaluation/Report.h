#pragma once
#include "Evaluation/Protocols.h"

#include <span>

namespace innergs {

/// Reports as tables, for reading and for programs; held-out reports come first, whatever their order.

std::string textReport(std::span<const EvaluationReport> reports);

/// One row per method and plane: protocol,case,method,plane,psnr,ssim,pooled_psnr,seconds,voxels,samples.
std::string csvReport(std::span<const EvaluationReport> reports);

/// {"protocol", "case", "samples", "peak", "voxels", "methods": {name: {"psnr", "ssim", "seconds",
/// "cpu_seconds" (not of protocol P), "per_plane"}}, "notes"}; an array of these for several reports. A
/// non-finite PSNR is null.
std::string jsonReport(std::span<const EvaluationReport> reports);

} // namespace innergs
