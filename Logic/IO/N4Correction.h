#pragma once
#include "Core/Image/Stack.h"

#include <stop_token>
#include <string>

namespace innergs {

/// Divides a scan's values by its smooth shading, estimated by ITK's N4BiasFieldCorrectionImageFilter
/// (Tustison et al., IEEE TMI 29, 2010) on a grid of about 4 mm, from the observed voxels: those above
/// zero if `masked`, else those above Otsu's threshold. Keeps their mean. Returns a sentence for the user:
/// the range of the shading, or why nothing was done (values far below zero, as in CT; slices with poses; too
/// few voxels). The result depends on ITK's number of threads in its last bits. Throws Error(Cancelled),
/// Error(UnsupportedImage) where ITK fails.
std::string correctByN4(Stack& stack, bool masked, const std::stop_token& stop = {});

} // namespace innergs
