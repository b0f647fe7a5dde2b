#pragma once
#include <cstdint>

namespace innergs {

/// Adds ssimWeight·Σ(1 − SSIM) to the loss and its gradient to r; window as in Metrics.h, zero-padded.
/// Samples with weight 0 count as equal.
double addSsimLoss(const float* image, const float* target, const std::uint8_t* weight, int nx, int ny,
                   int stride, double ssimWeight, float* gradient);

} // namespace innergs
