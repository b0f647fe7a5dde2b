#include "Evaluation/BackProjection.h"

#include "Core/Error.h"
#include "Core/Metrics.h"
#include "Core/Parallel.h"
#include "Evaluation/Baselines.h"

#include <algorithm>
#include <limits>

namespace innergs {
namespace {

// Measured on one to three 4 mm stacks with noise from none to 4 % of the range: less costs up to 1.7 dB with
// noise, more up to 1 dB without.
constexpr double noiseShare = 0.4;

struct Plane {
  double offset; // mm along the normal from the slice's centre
  double weight;
};

// Midpoints no further apart than the volume's own spacing along the normal: exact for a box over whole
// voxels.
std::vector<Plane> profilePlanes(const Stack& stack, const GridGeometry& volume) {
  if (stack.profile == SliceProfile::Point) return {{0, 1}};
  const double thickness = stack.thickness > 0 ? stack.thickness : stack.image.geometry.spacing[2];
  const Vec3 along = transpose(volume.direction) * column(stack.image.geometry.direction, 2);
  const double step =
      1 / norm({along[0] / volume.spacing[0], along[1] / volume.spacing[1], along[2] / volume.spacing[2]});
  const double tau = thickness / 2.3548200450309493;
  const double width = stack.profile == SliceProfile::Box ? thickness : 6 * tau;
  const int count = std::max(1, static_cast<int>(std::ceil(width / step - 1e-3)));
  std::vector<Plane> planes;
  double sum = 0;
  for (int p = 0; p < count; ++p) {
    const double offset = ((p + 0.5) / count - 0.5) * width;
    const double weight =
        stack.profile == SliceProfile::Box ? 1 : std::exp(-0.5 * offset * offset / (tau * tau));
    planes.push_back({offset, weight});
    sum += weight;
  }
  for (Plane& plane : planes)
    plane.weight /= sum;
  return planes;
}

} // namespace

std::vector<float> projectToStack(const Volume& volume, const Stack& stack, int threads) {
  const GridGeometry& g = stack.image.geometry;
  const auto& n = volume.geometry.size;
  const Affine3 toVolume = inverse(volume.geometry.indexToWorld());
  const Affine3 stackToVolume = toVolume * g.indexToWorld();
  const Vec3 normal = toVolume.linear * column(g.direction, 2); // voxels per mm
  const std::vector<Plane> planes = profilePlanes(stack, volume.geometry);
  std::vector<float> out(static_cast<std::size_t>(g.voxelCount()));
  ThreadPool pool(threads);
  pool.run(g.size[1] * g.size[2], [&](std::int64_t row) {
    const std::int64_t j = row % g.size[1], k = row / g.size[1];
    for (std::int64_t i = 0; i < g.size[0]; ++i) {
      const Vec3 centre = stackToVolume({double(i), double(j), double(k)});
      double sum = 0, weights = 0;
      for (const Plane& plane : planes) {
        Vec3 x = centre + plane.offset * normal;
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
          inside = inside && x[axis] >= -0.5 - 1e-6 && x[axis] <= double(n[axis]) - 0.5 + 1e-6;
          const double nearest = std::round(x[axis]); // rounding of the index maps
          if (std::abs(x[axis] - nearest) < 1e-6) x[axis] = nearest;
        }
        if (!inside) continue;
        sum += plane.weight * sampleLinear(volume, x);
        weights += plane.weight;
      }
      out[static_cast<std::size_t>(row * g.size[0] + i)] =
          weights > 0 ? static_cast<float>(sum / weights) : std::numeric_limits<float>::quiet_NaN();
    }
  });
  return out;
}

Volume backProject(std::span<const Stack> stacks, const GridGeometry& grid,
                   const BackProjectionSettings& settings) {
  Volume volume = averageUpsampled(stacks, grid, Interpolation::Cubic, settings.threads);
  double noise = 0; // mean variance
  if (settings.stopAtNoise)
    for (const Stack& stack : stacks)
      noise += std::pow(estimateNoise(stack.image, stack.observed), 2) / double(stacks.size());
  for (int iteration = 0; iteration < settings.iterations; ++iteration) {
    std::vector<Upsampled> updates;
    double squares = 0, count = 0;
    for (const Stack& stack : stacks) {
      if (settings.stop.stop_requested())
        throw Error(ErrorCode::Cancelled, "The back-projection was cancelled.");
      Stack difference = stack;
      const std::vector<float> seen = projectToStack(volume, stack, settings.threads);
      for (std::size_t p = 0; p < seen.size(); ++p) {
        const float d = stack.image.voxels[p] - seen[p];
        const bool known = std::isfinite(d) && (stack.observed.empty() || stack.observed[p]);
        difference.image.voxels[p] = known ? d : 0;
        if (known) {
          squares += double(d) * d;
          ++count;
        }
      }
      difference.observed.clear();
      // Linear, not cubic: 0.1 to 0.2 dB better on one, two and three stacks, and it amplifies noise less.
      updates.push_back(upsample(difference, grid, Interpolation::Linear, settings.threads));
    }
    if (squares <= noiseShare * noiseShare * noise * count) break;
    for (std::size_t p = 0; p < volume.voxels.size(); ++p) {
      double sum = 0, weights = 0;
      for (const Upsampled& update : updates) {
        sum += double(update.weight[p]) * update.volume.voxels[p];
        weights += update.weight[p];
      }
      if (weights > 0) volume.voxels[p] += static_cast<float>(sum / weights);
    }
  }
  return volume;
}

} // namespace innergs
