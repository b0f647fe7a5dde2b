#pragma once
#include "TestVolumes.h"

#include "Core/Features/Labelmap.h"
#include "Core/Motion/TimeSeries.h"

namespace innergs::testing {

/// A rigid motion about a point: rotation about z (rad), then a shift (mm).
struct RigidMotion {
  Vec3 centre{0, 0, 0};
  double angle = 0;
  Vec3 shift{0, 0, 0};

  Vec3 operator()(const Vec3& x) const { return centre + rotated(x - centre, angle) + shift; }
  Vec3 back(const Vec3& x) const { return centre + rotated(x - shift - centre, -angle); }
  static Vec3 rotated(const Vec3& d, double angle) {
    return {std::cos(angle) * d[0] - std::sin(angle) * d[1], std::sin(angle) * d[0] + std::cos(angle) * d[1],
            d[2]};
  }
};

/// Smooth blobs on a background, defined at every position (mm): 0 to about 200.
inline double blobs(const Vec3& x) {
  double value = 20;
  for (int n = 0; n < 9; ++n) {
    const Vec3 c{6.0 * (n % 3) - 6 + 0.7 * n, 6.0 * (n / 3) - 6, 1.5 * (n % 4) - 2};
    const Vec3 d = x - c;
    value +=
        (60 + 12 * n) * std::exp(-0.5 * (d[0] * d[0] / 4 + d[1] * d[1] / (2 + 0.4 * n) + d[2] * d[2] / 5));
  }
  return value;
}

/// The motion of the phantom at a time (s).
inline RigidMotion swing(double time) {
  return {{0.5, -0.5, 0}, 0.22 * std::sin(0.9 * time), {0.9 * std::sin(0.7 * time), 0.5 * time / 3, 0}};
}

inline GridGeometry phantomGrid() {
  return grid(24, 22, 7, {1, 1, 1.6}, {-11.5, -10.5, -4.8});
}

/// Frames of moving blobs.
inline TimeSeries movingPhantom(const std::vector<double>& times) {
  TimeSeries series{phantomGrid(), {}, times, "phantom", {}};
  for (const double time : times)
    series.frames.push_back(
        volumeInSpace(series.geometry, [&](const Vec3& x) { return blobs(swing(time).back(x)); }).voxels);
  return series;
}

/// Two labels of it: its bright parts at the left and at the right.
inline Labelmap movingLabels(const GridGeometry& geometry, double time) {
  return labelmapOf(volumeInSpace(geometry, [&](const Vec3& x) {
    const Vec3 tissue = swing(time).back(x);
    return blobs(tissue) < 60 ? 0.0 : tissue[0] < 1 ? 1.0 : 2.0;
  }));
}

/// The Dice coefficient of a label.
inline double dice(const Labelmap& a, const Labelmap& b, std::uint16_t label) {
  double both = 0, sum = 0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    both += a.voxels[v] == label && b.voxels[v] == label;
    sum += (a.voxels[v] == label) + (b.voxels[v] == label);
  }
  return 2 * both / sum;
}

inline std::vector<double> evenTimes(int count, double interval = 0.5) {
  std::vector<double> times;
  for (int f = 0; f < count; ++f)
    times.push_back(interval * f);
  return times;
}

} // namespace innergs::testing
