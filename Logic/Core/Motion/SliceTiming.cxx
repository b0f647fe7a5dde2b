#include "Core/Motion/SliceTiming.h"

#include "Core/Image/GridGeometry.h"

#include <algorithm>

namespace innergs {

SliceGroups sliceGroups(const SliceTiming& timing, const GridGeometry& geometry) {
  SliceGroups groups;
  for (int a = 0; a < timing.axis; ++a)
    groups.step *= geometry.size[a];
  groups.slices = geometry.size[timing.axis];
  groups.times = timing.times;
  std::sort(groups.times.begin(), groups.times.end());
  groups.times.erase(std::unique(groups.times.begin(), groups.times.end()), groups.times.end());
  if (groups.times.empty()) groups.times.push_back(0);
  for (std::int64_t s = 0; s < groups.slices; ++s)
    groups.ofSlice.push_back(
        timing.empty()
            ? 0
            : static_cast<int>(std::lower_bound(groups.times.begin(), groups.times.end(), timing.times[s]) -
                               groups.times.begin()));
  return groups;
}

} // namespace innergs
