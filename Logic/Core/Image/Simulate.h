#pragma once
#include "Core/Image/Stack.h"

namespace innergs {

/// Simulates a thick-slice acquisition: slices of `thickness` voxels along grid axis `axis` (0 = I, 1 = J,
/// 2 = K), box-averaged, one slice every `thickness` voxels; drops leftover voxels at the end.
/// The stack's K axis is the chosen axis. noise: standard deviation of added Gaussian noise (image units).
Stack simulateThickStack(const Volume& volume, int axis, int thickness, double noise = 0,
                         std::uint64_t seed = 1);

/// Adds Gaussian noise of a standard deviation (Box and Muller 1958), the same numbers on every platform.
void addNoise(std::vector<float>& voxels, double sigma, std::uint64_t seed);

/// Every k-th slice along `axis`, thin (profile Point, slice spacing k times the volume's).
Stack keepEvery(const Volume& volume, int axis, int k);

} // namespace innergs
