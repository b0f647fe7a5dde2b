#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Base/Parallel.h"

namespace innergs {

/// A first guess of the volume (normalised intensities) on an isotropic grid in the model frame: the mean
/// of the trilinearly interpolated stacks. `covered` is 1 in the observed voxels of any stack.
struct ProxyVolume {
  GridGeometry geometry; // in model coordinates (direction = identity)
  std::vector<float> voxels;
  std::vector<std::uint8_t> covered;
};
enum class Voxels { Observed, All }; // which voxels of the stacks count
ProxyVolume makeProxy(std::span<const Stack> stacks, const Affine3& modelToWorld, const IntensityMap& map,
                      double spacing, ThreadPool& pool, Voxels voxels = Voxels::Observed);

} // namespace innergs
