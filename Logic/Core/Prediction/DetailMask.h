#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/FilledImage.h"

#include <array>

namespace innergs {

/// Sets every voxel that lies within `reach` voxels, along each axis, of one that is set.
void dilate(std::vector<std::uint8_t>& mask, const std::array<std::int64_t, 3>& size,
            const std::array<std::int64_t, 3>& reach, ThreadPool& pool);

/// 1 near the body and wherever neighbouring voxels differ by more than noise (standard deviation, image
/// units) explains; 0 where the image is flat, as in air. body: 1 inside, like the image.
std::vector<std::uint8_t> detailMask(const FilledImage& filled, std::vector<std::uint8_t> body, double noise,
                                     ThreadPool& pool);

} // namespace innergs
