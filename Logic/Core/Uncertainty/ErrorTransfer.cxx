#include "Core/Uncertainty/ErrorTransfer.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/SliceOperator.h"
#include "Core/Base/Error.h"
#include "Core/Image/CubicConvolution.h"
#include "Core/Image/Simulate.h"
#include "Core/Uncertainty/ErrorCurve.h"
#include "Core/Uncertainty/LocalDetail.h"
#include "Core/Uncertainty/SimulatedGrids.h"
#include "Core/Uncertainty/SliceDistance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr int kDetails = 6;             // classes
constexpr Vec3 kTurn{0.62, 0.41, 0.53}; // radians: no axis stays an axis
constexpr std::int64_t kFewest = 500;   // samples of a class
constexpr double kFiner = 0.5; // share of the squares that the simulation lacks taken for finer detail

/// cubicAt(); beyond its faces the volume is mirrored at the centres of its outermost voxels.
float mirrored(const Volume& volume, Vec3 index) {
  for (int a = 0; a < 3; ++a) {
    const auto last = static_cast<double>(volume.geometry.size[a] - 1);
    const double at = last > 0 ? std::fmod(std::abs(index[a]), 2 * last) : 0;
    index[a] = std::min(at, 2 * last - at);
  }
  return cubicAt(volume, index);
}

/// The grid of what is scanned.
struct Cube {
  GridGeometry grid;
  double margin; // mm beside its and the scans' faces that are not scored

  Cube(std::span<const Stack> stacks, const Vec3& middle) : grid(simulationGrid(stacks, middle)) {
    margin = coarsestSlices(stacks) + 2 * grid.spacing[0];
  }
  /// Whether a place (LPS mm) is well inside the cube and one of the scans.
  bool scores(const Vec3& x, std::span<const GridGeometry> scans) const {
    return holds(grid, x) &&
           std::any_of(scans.begin(), scans.end(), [&](const GridGeometry& scan) { return holds(scan, x); });
  }
  bool holds(const GridGeometry& box, const Vec3& x) const {
    const Vec3 from = transpose(box.direction) * (x - box.centre()), extent = box.extent();
    for (int a = 0; a < 3; ++a)
      if (std::abs(from[a]) > std::max(0.25 * extent[a], 0.5 * extent[a] - margin)) return false;
    return true;
  }
};

/// The square of a deviation seen at held-out slices, without that of the noise.
double withoutNoise(double seen, double noise) {
  return std::max(0.0, seen * seen - noise * noise);
}

struct Point {
  double seen, error; // squares
};

/// error = slope·seen + offset, neither below 0: least squares of the relative differences. Below what was
/// seen the line says little, so no error counts as smaller than the smallest.
ErrorTransfer::Line lineThrough(const std::vector<Point>& points) {
  double xx = 0, x = 0, one = 0, xy = 0, y = 0, least = std::numeric_limits<double>::infinity();
  for (const Point& p : points) {
    least = std::min(least, p.error);
    const double w = 1 / std::max(p.error * p.error, 1e-300);
    xx += w * p.seen * p.seen;
    x += w * p.seen;
    one += w;
    xy += w * p.seen * p.error;
    y += w * p.error;
  }
  const double determinant = xx * one - x * x;
  if (determinant > 1e-12 * xx * one) {
    const ErrorTransfer::Line line{(xy * one - x * y) / determinant, (xx * y - x * xy) / determinant, least};
    if (line.slope >= 0 && line.offset >= 0) return line;
    if (line.offset < 0 && xx > 0) return {xy / xx, 0, least};
  }
  return {0, y / one, least};
}

} // namespace

ErrorTransfer::ErrorTransfer(const Volume& volume, std::span<const Stack> stacks, bool moved, double noise,
                             double radius, const PairFitter& fit, ThreadPool& pool)
    : noise_(noise) {
  const Vec3 middle = middleOf(localDetail(volume, radius, pool));
  const Cube cube(stacks, middle);
  const GridGeometry& grid = cube.grid;
  const auto voxels = static_cast<std::size_t>(grid.voxelCount());
  const std::int64_t edge = grid.size[0];
  // What is scanned.
  std::vector<float> truth(voxels);
  const Affine3 map =
      inverse(volume.geometry.indexToWorld()) * rigidAbout(middle, kTurn, {}) * grid.indexToWorld();
  pool.run(edge, [&](std::int64_t k) {
    for (std::int64_t j = 0; j < edge; ++j)
      for (std::int64_t i = 0; i < edge; ++i)
        truth[i + edge * (j + edge * k)] =
            mirrored(volume, map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
  });
  // How it is scanned.
  const SliceOperator op(grid, pool);
  std::vector<Stack> scans;
  std::vector<GridGeometry> boxes;
  for (Stack& scan : simulatedGrids(stacks, grid, moved)) {
    const auto& n = scan.image.geometry.size;
    if (n[2] < 3) continue;
    scan.image.voxels.assign(static_cast<std::size_t>(scan.image.geometry.voxelCount()), 0.f);
    const ProfileQuadrature profile =
        profileQuadrature(scan.profile, effectiveThickness(scan), grid.spacing[0]);
    for (const PlacedSlice& slice : placedSlices(scan, 0, 1, profile)) {
      const std::vector<float> seen = op.project(truth, slice);
      std::copy(seen.begin(), seen.end(), scan.image.voxels.begin() + slice.index * n[0] * n[1]);
    }
    addNoise(scan.image.voxels, noise, 7919 * (scans.size() + 1));
    boxes.push_back(scan.image.geometry);
    scans.push_back(std::move(scan));
  }
  const auto refuse = [] {
    throw Error(ErrorCode::NoData,
                "The uncertainty is unknown: the scans show too little for a simulation of "
                "their errors. Choose larger scans.");
  };
  if (scans.size() < stacks.size()) refuse();
  std::vector<float> near = sliceDistances(grid, scans, pool);
  const FitPair fitted = fit(std::move(scans), grid);
  if (fitted.second.voxels.empty()) refuse();
  // The errors at held-out slices.
  const Affine3 toIndex = inverse(grid.indexToWorld());
  const Volume secondDetail = localDetail(fitted.second, radius, pool);
  std::vector<HeldOutError> seen;
  for (const HeldOutValue& value : fitted.seen) {
    if (std::isfinite(value.difference) && cube.scores(value.at, boxes))
      seen.push_back({sampleLinear(secondDetail, toIndex(value.at)), value.difference});
  }
  if (static_cast<std::int64_t>(seen.size()) < kFewest) refuse();
  simulated_ = ErrorCurve(std::move(seen));
  // The errors of the volume fitted to all slices.
  const std::vector<float>& full = fitted.whole.voxels;
  const Volume detail = localDetail(fitted.whole, radius, pool);
  std::vector<float> details;
  std::vector<std::size_t> scored;
  const Affine3 toWorld = grid.indexToWorld();
  for (std::size_t v = 0; v < voxels; ++v) {
    const auto at = static_cast<std::int64_t>(v);
    const Vec3 index{static_cast<double>(at % edge), static_cast<double>(at / edge % edge),
                     static_cast<double>(at / (edge * edge))};
    if (!cube.scores(toWorld(index), boxes) || !std::isfinite(near[v])) continue;
    scored.push_back(v);
    details.push_back(detail.voxels[v]);
  }
  std::vector<double> edges;
  for (int d = 1; d < kDetails; ++d)
    edges.push_back(quantile(details, static_cast<double>(d) / kDetails));
  struct Class {
    std::vector<float> error;
    double detail = 0;
  };
  std::vector<Class> classes(kNear * kDetails);
  for (const std::size_t v : scored) {
    const auto d = std::upper_bound(edges.begin(), edges.end(), detail.voxels[v]) - edges.begin();
    Class& c = classes[static_cast<std::size_t>(distanceClass(near[v]) * kDetails + d)];
    c.error.push_back(std::abs(full[v] - truth[v]));
    c.detail += detail.voxels[v];
  }
  std::vector<Point> all;
  bool known[kNear] = {};
  for (int n = 0; n < kNear; ++n) {
    std::vector<Point> points;
    for (int d = 0; d < kDetails; ++d) {
      Class& c = classes[static_cast<std::size_t>(n) * kDetails + static_cast<std::size_t>(d)];
      if (static_cast<std::int64_t>(c.error.size()) < kFewest) continue;
      const double deviation = quantile(c.error, 0.9) / kNinety;
      points.push_back({withoutNoise(simulated_.at(c.detail / static_cast<double>(c.error.size())), noise),
                        deviation * deviation});
    }
    all.insert(all.end(), points.begin(), points.end());
    if (points.size() >= 3) line_[n] = lineThrough(points);
    known[n] = points.size() >= 3;
  }
  if (all.size() < 3) refuse();
  for (int n = 0; n < kNear; ++n)
    if (!known[n]) line_[n] = lineThrough(all);
  // Scales the lines so that together they hold 90 % of the simulated errors.
  std::vector<float> ratio;
  for (const std::size_t v : scored) {
    const double expected = kNinety * deviation(simulated_.at(detail.voxels[v]), detail.voxels[v], near[v]);
    if (expected > 0) ratio.push_back(static_cast<float>(std::abs(full[v] - truth[v]) / expected));
  }
  const double scale = quantile(ratio, 0.9);
  if (std::isfinite(scale) && scale > 0)
    for (Line& line : line_) {
      line.slope *= scale * scale;
      line.offset *= scale * scale;
      line.least *= scale * scale;
    }
}

double ErrorTransfer::deviation(double seen, double detail, double distance) const {
  const Line& line = line_[distanceClass(distance)];
  const double real = withoutNoise(seen, noise_);
  const double expected = std::min(real, withoutNoise(simulated_.at(detail), noise_));
  const double share = 1 - kFiner + kFiner * std::min(1.0, line.slope);
  return std::sqrt(std::max(line.least, line.slope * expected + line.offset) + share * (real - expected));
}

int ErrorTransfer::distanceClass(double distance) {
  return std::isfinite(distance) ? std::min(kNear - 1, static_cast<int>(kNear * distance)) : kNear - 1;
}

} // namespace innergs
