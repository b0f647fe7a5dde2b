#include "Core/Uncertainty/ErrorTransfer.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/SliceOperator.h"
#include "Core/Base/Error.h"
#include "Core/Image/Simulate.h"
#include "Core/Uncertainty/ErrorCurve.h"
#include "Core/Uncertainty/LocalDetail.h"
#include "Core/Uncertainty/Nearness.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kEdge = 96;      // voxels of the cube
constexpr int kDetails = 6;             // classes
constexpr double kFewestSlices = 8;     // of the thickest stack, in it
constexpr Vec3 kTurn{0.62, 0.41, 0.53}; // radians: no axis stays an axis
constexpr std::int64_t kFewest = 500;   // samples of a class

/// The middle of a volume's detail, LPS mm.
Vec3 middleOf(const Volume& detail) {
  const auto& n = detail.geometry.size;
  Vec3 sum{};
  double weights = 0;
  for (std::int64_t v = 0; v < detail.geometry.voxelCount(); ++v) {
    const double w = detail.voxels[static_cast<std::size_t>(v)];
    sum = sum + w * Vec3{static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                         static_cast<double>(v / (n[0] * n[1]))};
    weights += w;
  }
  return weights > 0 ? detail.geometry.indexToWorld()((1 / weights) * sum) : detail.geometry.centre();
}

/// Catmull-Rom's cubic; beyond its faces the volume is mirrored.
float mirrored(const Volume& volume, const Vec3& index) {
  const auto& n = volume.geometry.size;
  std::int64_t tap[3][4];
  double weight[3][4];
  for (int a = 0; a < 3; ++a) {
    const double low = std::floor(index[a]), t = index[a] - low;
    const double w[4] = {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t),
                         t * (0.5 + t * (2 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
    for (int m = 0; m < 4; ++m) {
      const std::int64_t period = 2 * std::max<std::int64_t>(1, n[a] - 1);
      const std::int64_t at = std::abs(static_cast<std::int64_t>(low) + m - 1) % period;
      tap[a][m] = std::min(at, period - at) % n[a];
      weight[a][m] = w[m];
    }
  }
  double sum = 0;
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y) {
      const float* row = volume.voxels.data() + n[0] * (tap[1][y] + n[1] * tap[2][z]);
      double line = 0;
      for (int x = 0; x < 4; ++x)
        line += weight[0][x] * row[tap[0][x]];
      sum += weight[1][y] * weight[2][z] * line;
    }
  return static_cast<float>(sum);
}

struct Cube {
  GridGeometry grid;
  double margin; // mm beside its and the scans' faces that are not scored

  Cube(std::span<const Stack> stacks, const Vec3& middle) {
    double finest = std::numeric_limits<double>::max(), coarsest = 0;
    for (const Stack& stack : stacks) {
      const Vec3& s = stack.image.geometry.spacing;
      finest = std::min({finest, s[0], s[1], s[2]});
      coarsest = std::max({coarsest, s[2], stack.thickness});
    }
    const double spacing = std::max(finest, (kFewestSlices + 2) * coarsest / static_cast<double>(kEdge));
    grid.direction = stacks.front().image.geometry.direction;
    grid.size = {kEdge, kEdge, kEdge};
    grid.spacing = {spacing, spacing, spacing};
    const double half = 0.5 * spacing * static_cast<double>(kEdge - 1);
    grid.origin = middle - grid.direction * Vec3{half, half, half};
    margin = coarsest + 2 * spacing;
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

/// The part of a stack in the cube, without its values.
Stack emptied(const Stack& stack, const GridGeometry& cube) {
  const GridGeometry& g = stack.image.geometry;
  const Affine3 map = inverse(g.indexToWorld()) * cube.indexToWorld();
  std::array<std::int64_t, 3> first, size;
  for (int a = 0; a < 3; ++a) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 index;
      for (int b = 0; b < 3; ++b)
        index[b] = (corner >> b & 1) ? static_cast<double>(kEdge - 1) : 0;
      low = std::min(low, map(index)[a]);
      high = std::max(high, map(index)[a]);
    }
    first[a] = std::clamp<std::int64_t>(std::llround(std::ceil(low)), 0, g.size[a] - 1);
    size[a] =
        std::clamp<std::int64_t>(std::llround(std::floor(high)), first[a], g.size[a] - 1) - first[a] + 1;
  }
  Stack part;
  part.image.geometry = cropped(g, first, size);
  part.image.voxels.assign(static_cast<std::size_t>(part.image.geometry.voxelCount()), 0.f);
  part.thickness = stack.thickness;
  part.profile = stack.profile;
  part.name = stack.name;
  return part;
}

/// The square of what is seen at a deviation, without that of the noise.
double withoutNoise(double seen, double noise) {
  return std::max(0.0, seen * seen - noise * noise);
}

struct Point {
  double seen, error; // squares
};

/// error = slope·seen + offset, neither below 0: least squares of the relative differences.
ErrorTransfer::Line lineThrough(const std::vector<Point>& points) {
  double xx = 0, x = 0, one = 0, xy = 0, y = 0;
  for (const Point& p : points) {
    const double w = 1 / std::max(p.error * p.error, 1e-300);
    xx += w * p.seen * p.seen;
    x += w * p.seen;
    one += w;
    xy += w * p.seen * p.error;
    y += w * p.error;
  }
  const double determinant = xx * one - x * x;
  if (determinant > 1e-12 * xx * one) {
    const ErrorTransfer::Line line{(xy * one - x * y) / determinant, (xx * y - x * xy) / determinant};
    if (line.slope >= 0 && line.offset >= 0) return line;
    if (line.offset < 0 && xx > 0) return {xy / xx, 0};
  }
  return {0, y / one};
}

} // namespace

ErrorTransfer::ErrorTransfer(const Volume& volume, std::span<const Stack> stacks, double noise, double radius,
                             const FitTwice& fit, ThreadPool& pool)
    : noise_(noise) {
  const Vec3 middle = middleOf(localDetail(volume, radius, pool));
  const Cube cube(stacks, middle);
  const GridGeometry& grid = cube.grid;
  const auto voxels = static_cast<std::size_t>(grid.voxelCount());
  // What is scanned.
  std::vector<float> truth(voxels);
  const Affine3 map =
      inverse(volume.geometry.indexToWorld()) * rigidAbout(middle, kTurn, {}) * grid.indexToWorld();
  pool.run(kEdge, [&](std::int64_t k) {
    for (std::int64_t j = 0; j < kEdge; ++j)
      for (std::int64_t i = 0; i < kEdge; ++i)
        truth[i + kEdge * (j + kEdge * k)] =
            mirrored(volume, map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
  });
  // How it is scanned.
  const SliceOperator op(grid, pool);
  std::vector<Stack> scans;
  std::vector<GridGeometry> boxes;
  for (const Stack& stack : stacks) {
    Stack scan = emptied(stack, grid);
    const auto& n = scan.image.geometry.size;
    if (n[2] < 3) continue;
    for (const PlacedSlice& slice : placedSlices(scan, 0, 1, grid.spacing[0])) {
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
  std::vector<float> near = nearness(grid, scans, pool);
  const FittedTwice fitted = fit(std::move(scans), grid);
  if (fitted.second.voxels.empty()) refuse();
  // The errors at withheld slices.
  const Affine3 toIndex = inverse(grid.indexToWorld());
  const Volume secondDetail = localDetail(fitted.second, radius, pool);
  std::vector<SeenError> seen;
  for (const WithheldValue& value : fitted.seen) {
    if (std::isfinite(value.difference) && cube.scores(value.at, boxes))
      seen.push_back({sampleLinear(secondDetail, toIndex(value.at)), value.difference});
  }
  if (static_cast<std::int64_t>(seen.size()) < kFewest) refuse();
  const ErrorCurve curve(std::move(seen));
  // The errors of the whole, beside them.
  const std::vector<float>& full = fitted.whole.voxels;
  const Volume detail = localDetail(fitted.whole, radius, pool);
  std::vector<float> details;
  std::vector<std::size_t> scored;
  const Affine3 toWorld = grid.indexToWorld();
  for (std::size_t v = 0; v < voxels; ++v) {
    const auto at = static_cast<std::int64_t>(v);
    const Vec3 index{static_cast<double>(at % kEdge), static_cast<double>(at / kEdge % kEdge),
                     static_cast<double>(at / (kEdge * kEdge))};
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
    Class& c = classes[static_cast<std::size_t>(nearClass(near[v]) * kDetails + d)];
    c.error.push_back(std::abs(full[v] - truth[v]));
    c.detail += detail.voxels[v];
  }
  std::vector<Point> all;
  bool known[kNear] = {};
  for (int n = 0; n < kNear; ++n) {
    std::vector<Point> points;
    for (int d = 0; d < kDetails; ++d) {
      Class& c = classes[static_cast<std::size_t>(n * kDetails + d)];
      if (static_cast<std::int64_t>(c.error.size()) < kFewest) continue;
      const double deviation = quantile(c.error, 0.9) / kNinety;
      points.push_back({withoutNoise(curve.at(c.detail / static_cast<double>(c.error.size())), noise),
                        deviation * deviation});
    }
    all.insert(all.end(), points.begin(), points.end());
    if (points.size() >= 3) line_[n] = lineThrough(points);
    known[n] = points.size() >= 3;
  }
  if (all.size() < 3) refuse();
  for (int n = 0; n < kNear; ++n)
    if (!known[n]) line_[n] = lineThrough(all);
  // The lines as a whole hold 90 % of the simulated errors.
  std::vector<float> ratio;
  for (const std::size_t v : scored) {
    const double expected = kNinety * deviation(curve.at(detail.voxels[v]), near[v]);
    if (expected > 0) ratio.push_back(static_cast<float>(std::abs(full[v] - truth[v]) / expected));
  }
  const double scale = quantile(ratio, 0.9);
  if (std::isfinite(scale) && scale > 0)
    for (Line& line : line_) {
      line.slope *= scale * scale;
      line.offset *= scale * scale;
    }
}

double ErrorTransfer::deviation(double seen, double nearness) const {
  const Line& line = line_[nearClass(nearness)];
  return std::sqrt(line.slope * withoutNoise(seen, noise_) + line.offset);
}

int ErrorTransfer::nearClass(double nearness) {
  return std::isfinite(nearness) ? std::min(kNear - 1, static_cast<int>(kNear * nearness)) : kNear - 1;
}

} // namespace innergs
