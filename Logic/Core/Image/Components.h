#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

namespace innergs {

/// Sets the voxels of value 1 that are face-connected to `seed` to 2 and returns their indices. size: voxels
/// along I, J, K. Throws Error(Cancelled) when stopped.
std::vector<std::int64_t> floodFill(std::vector<std::uint8_t>& voxels,
                                    const std::array<std::int64_t, 3>& size, std::int64_t seed,
                                    const std::stop_token& stop = {});

/// Removes the components of a mask (1 inside) that have fewer than `leastVoxels`, or with `largestOnly` all
/// but the largest.
void keepParts(std::vector<std::uint8_t>& mask, const std::array<std::int64_t, 3>& size,
               std::int64_t leastVoxels, bool largestOnly, const std::stop_token& stop = {});

} // namespace innergs
