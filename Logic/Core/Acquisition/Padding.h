#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// Voxels of several scans of one body that were filled up and not acquired, as by resampling to another
/// grid: 1, in a list per scan, empty if there are none. They have one value, are joined by faces to the
/// image's border, and at a place among them another scan shows the body nearly everywhere within `margin`
/// (mm). Left out are places that no other scan acquired. Voxels next to padding, which are interpolated from
/// it, count as padding. Scans with poses have none. part: of the scans, those that are compared. toWorld:
/// rigid, LPS mm, applied to each scan. Throws Error(Cancelled).
std::vector<std::vector<std::uint8_t>> paddedVoxels(std::span<const Stack> scans,
                                                    std::span<const std::size_t> part,
                                                    std::span<const Affine3> toWorld, double margin,
                                                    ThreadPool& pool);

/// A sentence for the user on a scan's padding; "" if there is none.
std::string paddingSentence(const std::vector<std::uint8_t>& padded, const std::string& name);

} // namespace innergs
