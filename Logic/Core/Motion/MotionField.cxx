#include "Core/Motion/MotionField.h"

#include "Core/Base/Error.h"
#include "Core/Motion/Pose.h"

#include <cmath>

namespace innergs {

std::vector<float> motionField(const DynamicField& field, double from, double to,
                               const GridGeometry& geometry, int threads, const std::stop_token& stop) {
  if (field.kind != DynamicKind::Motion)
    throw Error(ErrorCode::InvalidArgument,
                "The model's Gaussians stay in place and change their intensity, so there is no motion to "
                "write: fit the scan as one that moves (kind motion).");
  if (!std::isfinite(from) || !std::isfinite(to))
    throw Error(ErrorCode::InvalidArgument, "The times of a motion field must be finite.");
  constexpr int steps = 12; // of the fixed point x = X + u(X, from); u is smooth, and zero at the middle
  constexpr double enough = 1e-8; // mm², squared step
  const std::vector<float> before = nodesAt(field, from), after = nodesAt(field, to);
  const auto displaced = [&](const Vec3& x, const std::vector<float>& nodes) {
    const float at[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
    const auto u = field.lattice.at(field.lattice.place(at), nodes);
    return Vec3{u[0], u[1], u[2]};
  };
  const Affine3 toModel = inverse(field.canonical.modelToWorld) * geometry.indexToWorld();
  std::vector<float> out(static_cast<std::size_t>(geometry.voxelCount()) * 3);
  ThreadPool pool(threads);
  pool.setStop(stop);
  pool.blocks(geometry.voxelCount(), 1024, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t v = first; v < last; ++v) {
      const std::int64_t i = v % geometry.size[0], j = v / geometry.size[0] % geometry.size[1],
                         k = v / (geometry.size[0] * geometry.size[1]);
      const Vec3 x = toModel({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      Vec3 canonical = x;
      for (int n = 0; n < steps; ++n) {
        const Vec3 next = x - displaced(canonical, before), step = next - canonical;
        canonical = next;
        if (dot(step, step) < enough) break;
      }
      const Vec3 moved = field.canonical.modelToWorld.linear * (canonical + displaced(canonical, after) - x);
      for (int a = 0; a < 3; ++a)
        out[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(a)] = static_cast<float>(moved[a]);
    }
  });
  pool.throwIfStopped();
  return out;
}

double middleTime(const DynamicField& field) {
  return field.times[field.times.size() / 2];
}

} // namespace innergs
