#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// How well several real scans predict slices held out from all methods (options.heldOutFraction of each
/// scan, up to a third): the Gaussians, and the cubically interpolated average of the scans, as their headers
/// place them and as whole scans aligned. In the averages a held-out slice is first interpolated from its
/// four neighbours. Each slice is registered to each method's volume, without having taken part in it, and
/// seen through its profile; one gain per slice is removed. Scores the voxels that all methods predict:
/// PSNR pooled, NCC a mean over slices. masks: none, one for all scans or one per scan. Throws what
/// prepareInput() does, Error(InvalidArgument) for fewer than two scans, Error(NoData) where nothing can be
/// scored.
EvaluationReport evaluateScans(const std::vector<Stack>& scans, const std::vector<Mask>& masks,
                               const EvaluationOptions& options = {});

} // namespace innergs
