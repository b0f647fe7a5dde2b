#pragma once
#include "Core/Job/ReconstructionJob.h"

#include <vector>

namespace innergs {

/// A slice of several scans, and where it was found to lie.
struct FoundSlice {
  std::size_t scan = 0, slice = 0; // from 0
  SlicePose motion;                // beyond its scan's alignment
  Affine3 place;                   // slicePlace()
};

/// Scan after scan; empty where their motion was not looked for.
std::vector<FoundSlice> foundSlices(const ReconstructionResult& result);

} // namespace innergs
