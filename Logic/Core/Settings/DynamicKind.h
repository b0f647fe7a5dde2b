#pragma once

namespace innergs {

/// How a dynamic scan's field changes with time.
enum class DynamicKind {
  Motion,    // Gaussians that move and turn
  Intensity, // Gaussians that stay where they are and change their intensity
  Network    // Gaussians changed by a deformation network, as in the paper
};

} // namespace innergs
