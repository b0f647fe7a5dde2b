#pragma once
#include "Core/Render/Render.h"

namespace innergs {

/// The field at points (LPS mm). Alpha blending: each on a slice normal to the model's third axis.
std::vector<float> renderPoints(const GaussianField& field, std::span<const Vec3> points,
                                const RenderOptions& options = {});

} // namespace innergs
