#pragma once
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// Slices (K) of a scan that were lost: all their voxels have one value, at half or more of the pixels where
/// the nearest other slice on either side shows the body, which must be 1 % of them at least. None if more
/// than a tenth of the scan's slices are like that: then it may be what it shows.
std::vector<std::int64_t> blankSlices(const Stack& scan);

/// A sentence for the user on a scan's blank slices; "" if there are none.
std::string blankSlicesSentence(std::span<const std::int64_t> slices, const std::string& name);

} // namespace innergs
