#pragma once
#include "Core/Image/Linear.h"

namespace innergs {

/// The index axis that counts the slices if the file does not say: the one whose spacing (mm) is clearly
/// coarser than the other two (thick slices), else K.
inline int sliceAxisOf(const Vec3& spacing) {
  constexpr double clearly = 1.2;
  for (int axis = 0; axis < 2; ++axis)
    if (spacing[axis] >= clearly * spacing[(axis + 1) % 3] &&
        spacing[axis] >= clearly * spacing[(axis + 2) % 3])
      return axis;
  return 2;
}

} // namespace innergs
