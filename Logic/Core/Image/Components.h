#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

namespace innergs {

/// The voxels of value 1 that hang together with `seed`, over faces; they become 2. size: voxels along I, J,
/// K. Throws Error(Cancelled) when stopped.
std::vector<std::int64_t> floodFill(std::vector<std::uint8_t>& voxels,
                                    const std::array<std::int64_t, 3>& size, std::int64_t seed,
                                    const std::stop_token& stop = {});

/// Empties a mask (1 inside) of its parts below `leastVoxels`, or with `largestOnly` of all but the largest
/// one.
void keepParts(std::vector<std::uint8_t>& mask, const std::array<std::int64_t, 3>& size,
               std::int64_t leastVoxels, bool largestOnly, const std::stop_token& stop = {});

} // namespace innergs
