#include "Core/Image/Metrics.h"

#include "Core/Base/Error.h"
#include "Core/Image/Ssim.h"

#include <limits>

namespace innergs {
namespace {

// Squared error over the voxels whose truth is finite.
struct SquaredError {
  double sum = 0;
  std::int64_t count = 0;

  void add(float image, float truth) {
    if (!std::isfinite(truth)) return;
    const double d = double(image) - double(truth);
    sum += d * d;
    ++count;
  }
  double psnr(double range) const {
    if (count == 0) return std::numeric_limits<double>::quiet_NaN();
    if (sum == 0) return std::numeric_limits<double>::infinity();
    return 10 * std::log10(range * range * double(count) / sum);
  }
};

void checkPair(const Volume& image, const Volume& truth) {
  if (image.geometry.size != truth.geometry.size || image.voxels.size() != truth.voxels.size() ||
      image.voxels.size() != static_cast<std::size_t>(truth.geometry.voxelCount()))
    throw Error(ErrorCode::InvalidArgument,
                "Image and truth differ in size: resample one onto the other first.");
}

} // namespace

double psnrOf(double mse) {
  return mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity();
}

double pooledPsnr(std::span<const float> image, std::span<const float> truth,
                  std::span<const std::uint8_t> mask, double range) {
  if (image.size() != truth.size() || (!mask.empty() && mask.size() != truth.size()))
    throw Error(ErrorCode::InvalidArgument, "Image, truth and mask differ in size.");
  SquaredError error;
  for (std::size_t p = 0; p < truth.size(); ++p)
    if (mask.empty() || mask[p]) error.add(image[p], truth[p]);
  return error.psnr(range);
}

Quality sliceQuality(const Volume& image, const Volume& truth, int axis, std::int64_t index, double range) {
  checkPair(image, truth);
  if (axis < 0 || axis > 2 || index < 0 || index >= truth.geometry.size[axis])
    throw Error(ErrorCode::InvalidArgument, "The slice does not lie inside the volume.");
  const auto& n = truth.geometry.size;
  const std::int64_t stride[3] = {1, n[0], n[0] * n[1]};
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  std::vector<float> a, b;
  a.reserve(static_cast<std::size_t>(n[u] * n[v]));
  b.reserve(a.capacity());
  for (std::int64_t y = 0; y < n[v]; ++y)
    for (std::int64_t x = 0; x < n[u]; ++x) {
      const auto p = static_cast<std::size_t>(index * stride[axis] + y * stride[v] + x * stride[u]);
      a.push_back(image.voxels[p]);
      b.push_back(truth.voxels[p]);
    }
  const std::vector<float> map = ssimMap(a, b, static_cast<int>(n[u]), static_cast<int>(n[v]), range);
  SquaredError error;
  double ssim = 0;
  for (std::size_t p = 0; p < map.size(); ++p) {
    error.add(a[p], b[p]);
    if (std::isfinite(b[p])) ssim += map[p];
  }
  return {error.psnr(range),
          error.count ? ssim / double(error.count) : std::numeric_limits<double>::quiet_NaN(), error.count};
}

Quality pooledQuality(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask,
                      double range, const std::optional<std::vector<std::int64_t>>& slices,
                      const std::stop_token& stop) {
  checkPair(image, truth);
  if (!mask.empty() && mask.size() != truth.voxels.size())
    throw Error(ErrorCode::InvalidArgument, "The mask differs from the truth in size.");
  const auto& n = truth.geometry.size;
  const auto plane = static_cast<std::size_t>(n[0] * n[1]);
  std::vector<std::int64_t> chosen;
  if (slices)
    chosen = *slices;
  else
    for (std::int64_t k = 0; k < n[2]; ++k)
      chosen.push_back(k);

  SquaredError error;
  double ssim = 0;
  for (std::int64_t k : chosen) {
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "The scoring was cancelled.");
    if (k < 0 || k >= n[2]) throw Error(ErrorCode::InvalidArgument, "A slice index lies outside the volume.");
    const std::size_t first = plane * static_cast<std::size_t>(k);
    const std::span<const float> a(image.voxels.data() + first, plane), b(truth.voxels.data() + first, plane);
    const auto in = [&](std::size_t p) { return (mask.empty() || mask[first + p]) && std::isfinite(b[p]); };
    bool any = false;
    for (std::size_t p = 0; p < plane && !any; ++p)
      any = in(p);
    if (!any) continue;
    const std::vector<float> map = ssimMap(a, b, static_cast<int>(n[0]), static_cast<int>(n[1]), range);
    for (std::size_t p = 0; p < plane; ++p)
      if (in(p)) {
        error.add(a[p], b[p]);
        ssim += map[p];
      }
  }
  return {error.psnr(range),
          error.count ? ssim / double(error.count) : std::numeric_limits<double>::quiet_NaN(), error.count};
}

} // namespace innergs
