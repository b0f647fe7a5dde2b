#pragma once
#include <span>
#include <vector>

namespace innergs {

/// The SSIM map of one slice (width×height, row-major), with borders reflected.
std::vector<float> ssimMap(std::span<const float> image, std::span<const float> truth, int width, int height,
                           double range);

} // namespace innergs
