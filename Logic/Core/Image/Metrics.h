#pragma once
#include "Core/Image/Volume.h"

#include <optional>
#include <stop_token>

namespace innergs {

/// Quality of an image against the truth. PSNR in dB with peak = `range`; SSIM (Wang et al. 2004) with an
/// 11×11 Gaussian window of σ 1.5, K1 = .01, K2 = .03, on 2D slices.
struct Quality {
  double psnr = 0, ssim = 0;
  std::int64_t voxels = 0;
};

/// PSNR in dB of a mean squared error, for a peak of 1; infinite without an error.
double psnrOf(double mse);

/// PSNR pooled over voxels with mask ≠ 0 (empty mask: all). Infinite for identical images.
double pooledPsnr(std::span<const float> image, std::span<const float> truth,
                  std::span<const std::uint8_t> mask, double range);

/// Quality of slice `index` along `axis` (0, 1, 2) of a volume.
Quality sliceQuality(const Volume& image, const Volume& truth, int axis, std::int64_t index, double range);

/// Protocol H: PSNR pooled over the mask within the chosen K-slices, and SSIM (one map per K-slice) averaged
/// over the same voxels. `slices`: K indices; nullopt = all. Throws Error(Cancelled) when stopped.
Quality pooledQuality(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask,
                      double range, const std::optional<std::vector<std::int64_t>>& slices = std::nullopt,
                      const std::stop_token& stop = {});

} // namespace innergs
