#pragma once
#include "Core/Render/Render.h"

namespace innergs {

/// An observed voxel, e.g. at a mask's ragged edge, may have lost every Gaussian that reached it, and with
/// them the gradient that would bring one back: gives it one of its own, too small to reach its neighbours.
/// Adds `most` at most, the strongest first, and then sorts the field along a Morton curve. stacks: with
/// `observed`; those with poses are left out. options: to render the field. Returns whether it added any.
bool coverUnreached(GaussianField& field, std::span<const Stack> stacks, std::int64_t most,
                    RenderOptions options);

} // namespace innergs
