#pragma once
#include "Core/Image/Stack.h"

#include <stop_token>
#include <string>

namespace innergs {

/// Divides a scan's values by its smooth shading as ITK's N4BiasFieldCorrectionImageFilter finds it (Tustison
/// et al., IEEE TMI 29, 2010), shrunk to about 4 mm, in the observed voxels: all above zero if they are
/// `masked`, else those above Otsu's threshold. Their mean stays. Returns a sentence for the user: by how
/// much, or why nothing was done (values far below zero, as in CT, slices with poses, nothing to see). The
/// result depends on ITK's number of threads in its last bits. Throws Error(Cancelled),
/// Error(UnsupportedImage) where ITK fails.
std::string correctByN4(Stack& stack, bool masked, const std::stop_token& stop = {});

} // namespace innergs
