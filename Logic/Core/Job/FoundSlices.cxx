#include "Core/Job/FoundSlices.h"

namespace innergs {

std::vector<FoundSlice> foundSlices(const ReconstructionResult& result) {
  std::vector<FoundSlice> found;
  for (std::size_t scan = 0; scan < result.sliceMotion.slices.size(); ++scan)
    for (std::size_t slice = 0; slice < result.sliceMotion.slices[scan].size(); ++slice)
      found.push_back({scan, slice, result.sliceMotion.slices[scan][slice], slicePlace(result, scan, slice)});
  return found;
}

} // namespace innergs
