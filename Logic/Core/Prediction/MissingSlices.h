#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// Of the slices with even or odd numbers (parity 0 or 1), the voxels that are not known between two that
/// are, in the slices before and after; sorted. Empty where these are less than 0.5 % of what is known.
std::vector<std::size_t> missingVoxels(const Stack& scan, int parity);

/// The scan with these voxels interpolated by completeSlices(), and known.
Stack withInterpolated(const Stack& scan, std::span<const std::vector<std::size_t>> voxels, ThreadPool& pool);

/// The scan from slice `first` on.
Stack fromSlice(const Stack& scan, std::int64_t first);

/// Every fourth slice from the second on that lies between two others, which tell how well missing ones are
/// interpolated.
std::vector<std::int64_t> probeSlices(const Stack& scan);

} // namespace innergs
