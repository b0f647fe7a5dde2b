#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Volume.h"

namespace innergs {

/// How much a volume changes around each voxel: the root mean square of its gradient (per mm) over a box of
/// about ± radius mm. On it depends how far an interpolation may be from the truth.
Volume localDetail(const Volume& volume, double radius, ThreadPool& pool);

} // namespace innergs
