#pragma once

namespace innergs {

/// How a moving scan's field changes with time.
enum class DynamicKind {
  Motion,    // Gaussians that are carried and turned
  Intensity, // Gaussians that stay where they are and change their intensity
  Network    // Gaussians changed by a deformation network: the paper's
};

} // namespace innergs
