#include "Evaluation/Baselines.h"

#include "Core/Base/Error.h"
#include "Core/Image/FilledImage.h"
#include "Evaluation/ItkInterpolation.h"
#include "Evaluation/SeparableResample.h"

namespace innergs {
namespace {

std::vector<float> resample(const Volume& image, const GridGeometry& grid, Interpolation kind,
                            ThreadPool& pool) {
  if (const auto map = alignedAxes(image.geometry, grid))
    return resampleAligned(image, grid, *map, kind, pool);
  return resampleWithItk(image, grid, kind, pool);
}

std::vector<float> insideBox(const GridGeometry& image, const GridGeometry& grid, ThreadPool& pool) {
  const Affine3 toImage = inverse(image.indexToWorld()) * grid.indexToWorld();
  std::vector<float> weight(static_cast<std::size_t>(grid.voxelCount()));
  pool.run(grid.size[2], [&](std::int64_t k) {
    std::size_t at = static_cast<std::size_t>(k * grid.size[0] * grid.size[1]);
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i, ++at) {
        const Vec3 x = toImage({double(i), double(j), double(k)});
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis)
          inside = inside && x[axis] >= -0.5 - 1e-6 && x[axis] <= double(image.size[axis]) - 0.5 + 1e-6;
        weight[at] = inside ? 1.0f : 0.0f;
      }
  });
  return weight;
}

} // namespace

Upsampled upsample(const Stack& stack, const GridGeometry& grid, Interpolation kind, int threads,
                   const std::stop_token& stop) {
  checkStack(stack);
  checkGeometry(grid, "The output grid");
  if (!stack.poses.empty())
    throw Error(ErrorCode::InvalidArgument,
                "Interpolation of a stack needs slices on one grid: remove the slice poses.");
  ThreadPool pool(threads);
  pool.setStop(stop);
  const FilledImage filled = filledImage(stack, stop);
  Upsampled result{{grid, resample(filled.image, grid, kind, pool)},
                   insideBox(stack.image.geometry, grid, pool)};
  if (!filled.known.empty()) {
    const Volume known{stack.image.geometry, {filled.known.begin(), filled.known.end()}};
    const std::vector<float> share = resample(known, grid, Interpolation::Linear, pool);
    for (std::size_t p = 0; p < share.size(); ++p)
      result.weight[p] *= share[p];
  }
  return result;
}

Volume averageOf(std::span<const Upsampled> upsampled, const std::stop_token& stop) {
  if (upsampled.empty()) throw Error(ErrorCode::InvalidArgument, "An average needs at least one stack.");
  Volume result{upsampled[0].volume.geometry, std::vector<float>(upsampled[0].volume.voxels.size())};
  constexpr std::size_t stride = 1 << 18; // voxels between checks of the stop token
  for (std::size_t p = 0; p < result.voxels.size(); ++p) {
    if (p % stride == 0 && stop.stop_requested())
      throw Error(ErrorCode::Cancelled, "The interpolation was cancelled.");
    double sum = 0, weights = 0, plain = 0;
    for (const Upsampled& u : upsampled) {
      sum += double(u.weight[p]) * u.volume.voxels[p];
      weights += u.weight[p];
      plain += u.volume.voxels[p];
    }
    result.voxels[p] = static_cast<float>(weights > 1e-3 ? sum / weights : plain / double(upsampled.size()));
  }
  return result;
}

Volume averageUpsampled(std::span<const Stack> stacks, const GridGeometry& grid, Interpolation kind,
                        int threads, const std::stop_token& stop) {
  std::vector<Upsampled> upsampled;
  for (const Stack& stack : stacks)
    upsampled.push_back(upsample(stack, grid, kind, threads, stop));
  return averageOf(upsampled, stop);
}

} // namespace innergs
