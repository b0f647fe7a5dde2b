#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Volume.h"

namespace innergs {

/// How much a volume changes around each voxel: the root mean square of its gradient (per mm) over a box of
/// about ± radius mm. The error of an interpolation depends on it.
Volume localDetail(const Volume& volume, double radius, ThreadPool& pool);

/// The centre of the detail, LPS mm.
Vec3 middleOf(const Volume& detail);

} // namespace innergs
