#include "Core/Motion/MotionField.h"

#include "Core/Base/Error.h"
#include "Core/Motion/Pose.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Where points of the canonical field have moved to at a time.
class Displacements {
public:
  Displacements(const DynamicField& field, double time) : field_(field), time_(time) {
    if (field.kind == DynamicKind::Motion) nodes_ = nodesAt(field, time);
  }

  /// out: the displacements of points; both in mm, model frame.
  void at(const std::vector<Vec3>& points, std::vector<Vec3>& out) const {
    out.resize(points.size());
    std::vector<float> coordinates;
    coordinates.reserve(3 * points.size());
    for (const Vec3& x : points)
      for (const double c : x)
        coordinates.push_back(static_cast<float>(c));
    if (field_.kind == DynamicKind::Motion) {
      for (std::size_t p = 0; p < points.size(); ++p) {
        const auto u = field_.motionGrid.at(field_.motionGrid.place(coordinates.data() + 3 * p), nodes_);
        out[p] = {u[0], u[1], u[2]};
      }
      return;
    }
    ThreadPool here(1);
    std::vector<float> changes(points.size() * DeformationNetwork::kOutputs);
    DeformationEvaluator(field_.network, coordinates, networkKernels(""))
        .forward(field_.network, time_, changes, here);
    for (std::size_t p = 0; p < points.size(); ++p)
      for (int a = 0; a < 3; ++a)
        out[p][a] = static_cast<double>(changes[p * DeformationNetwork::kOutputs + a]);
  }

private:
  const DynamicField& field_;
  double time_;
  std::vector<float> nodes_;
};

} // namespace

std::vector<float> motionField(const DynamicField& field, double from, double to,
                               const GridGeometry& geometry, int threads, const std::stop_token& stop) {
  if (field.kind == DynamicKind::Intensity)
    throw Error(ErrorCode::InvalidArgument,
                "The model's Gaussians stay in place and change their intensity, so there is no motion to "
                "write: fit the scan as one that moves (kind motion).");
  if (!std::isfinite(from) || !std::isfinite(to))
    throw Error(ErrorCode::InvalidArgument, "The times of a motion field must be finite.");
  constexpr int steps = 12; // of the fixed point x = X + u(X, from); u is smooth, and zero at the middle
  constexpr double enough = 1e-8; // mm², squared step
  const Displacements before(field, from), after(field, to);
  const Affine3 toModel = inverse(field.canonical.modelToWorld) * geometry.indexToWorld();
  std::vector<float> out(static_cast<std::size_t>(geometry.voxelCount()) * 3);
  ThreadPool pool(threads);
  pool.setStop(stop);
  pool.blocks(geometry.voxelCount(), 1024, [&](std::int64_t first, std::int64_t last) {
    std::vector<Vec3> asked, canonical, moved;
    for (std::int64_t v = first; v < last; ++v)
      asked.push_back(toModel({static_cast<double>(v % geometry.size[0]),
                               static_cast<double>(v / geometry.size[0] % geometry.size[1]),
                               static_cast<double>(v / (geometry.size[0] * geometry.size[1]))}));
    canonical = asked;
    for (int n = 0; n < steps; ++n) {
      before.at(canonical, moved);
      double most = 0;
      for (std::size_t p = 0; p < asked.size(); ++p) {
        const Vec3 next = asked[p] - moved[p], step = next - canonical[p];
        canonical[p] = next;
        most = std::max(most, dot(step, step));
      }
      if (most < enough) break;
    }
    after.at(canonical, moved);
    for (std::size_t p = 0; p < asked.size(); ++p) {
      const Vec3 d = field.canonical.modelToWorld.linear * (canonical[p] + moved[p] - asked[p]);
      for (int a = 0; a < 3; ++a)
        out[3 * (static_cast<std::size_t>(first) + p) + static_cast<std::size_t>(a)] =
            static_cast<float>(d[a]);
    }
  });
  pool.throwIfStopped();
  return out;
}

double middleTime(const DynamicField& field) {
  return field.times[field.times.size() / 2];
}

} // namespace innergs
