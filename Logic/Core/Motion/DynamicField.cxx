#include "Core/Motion/DynamicField.h"

#include "Core/Base/Error.h"
#include "Core/Job/JobInput.h"
#include "Core/Motion/Pose.h"
#include "Core/Render/Render.h"
#include "Core/Settings/SettingsTable.h"

#include <cmath>

namespace innergs {

const char* dynamicKindName(DynamicKind kind) {
  return settingNamed("kind").words[static_cast<std::size_t>(kind)].name;
}

std::optional<DynamicKind> dynamicKindNamed(const std::string& name) {
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Intensity, DynamicKind::Network})
    if (name == dynamicKindName(kind)) return kind;
  return {};
}

int coefficientsInTime(const DynamicField& field) {
  switch (field.kind) {
  case DynamicKind::Motion:
    return field.motion.coefficients;
  case DynamicKind::Intensity:
    return field.change.coefficients;
  case DynamicKind::Network:
    return field.network.levels.empty() ? 0 : field.network.levels.front().times;
  }
  return 0;
}

DynamicField emptyField(DynamicKind kind, const TimeSeries& series, const IntensityMap& map, double cutoff) {
  DynamicField field;
  field.kind = kind;
  field.times = series.times;
  GaussianField& c = field.canonical;
  c.modelToWorld = modelFrame(series.geometry);
  c.intensityScale = map.scale;
  c.intensityOffset = map.offset;
  c.cutoff = cutoff;
  c.domain = series.geometry;
  c.range = rangeOf(series);
  return field;
}

void checkDynamicField(const DynamicField& field) {
  checkField(field.canonical);
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The dynamic model cannot be used: " + what);
  };
  if (field.times.size() < 2) fail("it has fewer than two frame times.");
  for (std::size_t f = 0; f < field.times.size(); ++f)
    if (!std::isfinite(field.times[f]) || (f > 0 && !(field.times[f] > field.times[f - 1])))
      fail("its frame times do not increase.");
  const auto checkSpline = [&](const TimeSpline& s, std::span<const float> values, std::size_t each,
                               float most) {
    if (s.coefficients != 1 && s.coefficients < 4) fail("a spline in time has too few coefficients.");
    if (!std::isfinite(s.start) || !std::isfinite(s.end) || !(s.end > s.start))
      fail("a spline in time has no extent.");
    if (values.size() != static_cast<std::size_t>(s.coefficients) * each)
      fail("a spline in time has another size than it says.");
    for (const float v : values)
      if (!(std::fabs(v) <= most)) fail("a spline in time is not finite.");
  };
  const auto gaussians = static_cast<std::size_t>(field.size());
  if (field.kind == DynamicKind::Intensity) return checkSpline(field.change, field.changes, gaussians, 1e12f);
  if (field.anchors.size() != 3 * gaussians) fail("its anchors are not one per Gaussian.");
  for (const float x : field.anchors)
    if (!(std::fabs(x) <= 1e6f)) fail("its anchors are not finite.");
  if (field.kind == DynamicKind::Network) return checkDeformation(field.network);
  for (int a = 0; a < 3; ++a)
    if (field.motionGrid.size[a] < 2 || field.motionGrid.size[a] > 4096 ||
        !std::isfinite(field.motionGrid.origin[a]) || !(field.motionGrid.spacing[a] > 0) ||
        !(field.motionGrid.spacing[a] < 1e6))
      fail("its motion grid is out of range.");
  checkSpline(field.motion, field.nodes,
              static_cast<std::size_t>(field.motionGrid.nodes()) * MotionGrid::kValues, 1e6f);
  if (!field.ownPath.empty()) checkSpline(field.own, field.ownPath, 3 * gaussians, 1e6f);
}

void addChanges(const GaussianField& canonical, std::span<const float> changes, GaussianField& out,
                ThreadPool& pool) {
  pool.blocks(canonical.size(), 4096, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      Gaussian gaussian = canonical.gaussians[i];
      const float* d = changes.data() + 16 * i;
      for (int a = 0; a < 3; ++a) {
        gaussian.mean[a] += d[a];
        gaussian.logScale[a] += d[3 + a];
      }
      for (int a = 0; a < 4; ++a)
        gaussian.quaternion[a] += d[6 + a];
      gaussian.logWeight += d[10];
      gaussian.intensity += d[11];
      out.gaussians[i] = gaussian;
    }
  });
}

void poseAt(const DynamicField& field, double time, GaussianField& out, ThreadPool& pool) {
  if (field.kind == DynamicKind::Motion) {
    Poser(field).pose(field, nodesAt(field, time), time, out, pool);
    return;
  }
  if (field.kind == DynamicKind::Network) {
    std::vector<float> changes(16 * static_cast<std::size_t>(field.size()));
    DeformationEvaluator(field.network, field.anchors, networkKernels(""))
        .forward(field.network, time, changes, pool);
    addChanges(field.canonical, changes, out, pool);
    return;
  }
  const TimeSpline::Weights w = field.change.at(time);
  const auto count = static_cast<std::size_t>(field.size());
  pool.blocks(field.size(), 4096, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      out.gaussians[i] = field.canonical.gaussians[i];
      for (int a = 0; a < w.count; ++a)
        out.gaussians[i].intensity += w.weight[a] * field.changes[(w.first + a) * count + i];
    }
  });
}

GaussianField fieldAt(const DynamicField& field, double time) {
  GaussianField out = field.canonical;
  ThreadPool pool(1);
  poseAt(field, time, out, pool);
  return out;
}

std::vector<float> acquiredFrame(const DynamicField& field, const TimeSeries& series, double time,
                                 const RenderOptions& options) {
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  GaussianField posed = field.canonical;
  const SliceGroups groups = sliceGroups(series.sliceTiming, series.geometry);
  if (groups.times.size() == 1) {
    poseAt(field, time + groups.times[0], posed, pool);
    return render(posed, series.geometry, options).voxels;
  }
  const int axis = series.sliceTiming.axis;
  std::vector<float> frame(static_cast<std::size_t>(series.geometry.voxelCount()));
  GridGeometry slice = series.geometry;
  slice.size[axis] = 1;
  for (std::size_t g = 0; g < groups.times.size(); ++g) {
    poseAt(field, time + groups.times[g], posed, pool);
    for (std::int64_t s = 0; s < groups.slices; ++s) {
      if (groups.ofSlice[s] != static_cast<int>(g)) continue;
      Vec3 corner{0, 0, 0};
      corner[axis] = static_cast<double>(s);
      slice.origin = series.geometry.indexToWorld()(corner);
      const std::vector<float> values = render(posed, slice, options).voxels;
      const auto count = static_cast<std::int64_t>(values.size());
      for (std::int64_t v = 0; v < count; ++v) // inserts the index s along the axis
        frame[v % groups.step + groups.step * (s + groups.slices * (v / groups.step))] = values[v];
    }
  }
  return frame;
}

} // namespace innergs
