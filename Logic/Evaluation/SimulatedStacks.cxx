#include "Evaluation/SimulatedStacks.h"

#include "Core/Acquisition/Observation.h"
#include "Core/Alignment/Rigid.h"
#include "Core/Base/Error.h"
#include "Core/Base/Random.h"
#include "Core/Image/Region.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/ItkInterpolation.h"
#include "Evaluation/Protocols.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace innergs {
namespace {

constexpr double kLargestPixel = 16; // voxels of the volume

void checkCase(const StacksCase& c, const GridGeometry& volume) {
  const auto refuse = [](const std::string& sentence) { throw Error(ErrorCode::InvalidArgument, sentence); };
  for (const double pixel : c.pixels)
    if (!(std::isfinite(pixel) && pixel >= 0) || pixel > kLargestPixel * volume.spacing[0])
      refuse("The pixels of the stacks must be at least 0 mm and at most 16 voxels of the volume.");
  if (c.stacks < 1 || c.stacks > 3) refuse("The number of stacks must be 1, 2 or 3.");
  for (const double x : {c.thickness, c.gap, c.motion, c.turn, c.shading, c.gain, c.noise})
    if (!std::isfinite(x) || x < 0)
      refuse("Thickness, gap, motion, turn, shading, gain and noise of the stacks must be finite and at "
             "least 0.");
  if (c.motionPackets < 0) refuse("The number of packets that move must be at least 0.");
  if (!(c.thickness > 0)) refuse("The slices of the stacks need a thickness above 0 mm.");
  if (c.shading >= 1 || c.gain >= 1) refuse("Shading and gain are shares: give less than 1.");
  for (const std::int64_t n : volume.size)
    if (c.central < 0 || c.central > n)
      refuse("The middle cube has more voxels than the volume along an axis: give a smaller one.");
}

Volume middleOf(const Volume& volume, int edge) {
  if (edge == 0) return volume;
  const auto& n = volume.geometry.size;
  std::array<std::int64_t, 3> first;
  for (int a = 0; a < 3; ++a)
    first[a] = (n[a] - edge) / 2;
  return cropped(volume, IndexBlock{first, {edge, edge, edge}});
}

/// The same slices with square pixels of another size.
GridGeometry withPixels(GridGeometry g, double pixel) {
  Vec3 first{};
  for (int a = 0; a < 2; ++a) {
    first[a] = 0.5 * (pixel / g.spacing[a] - 1);
    g.size[a] = static_cast<std::int64_t>(static_cast<double>(g.size[a]) * g.spacing[a] / pixel + 1e-6);
  }
  g.origin = g.indexToWorld()(first);
  g.spacing[0] = g.spacing[1] = pixel;
  return g;
}

/// Thick slices along one axis of the grid, from face to face. pixel: mm; 0: the grid's voxels.
Stack emptyStack(const GridGeometry& scanned, int axis, const StacksCase& c, double pixel) {
  Stack stack;
  GridGeometry& g = stack.image.geometry = withSliceAxis(scanned, axis);
  const double voxel = g.spacing[2], distance = c.thickness + c.gap;
  g.size[2] = static_cast<std::int64_t>((static_cast<double>(g.size[2]) * voxel + c.gap) / distance + 1e-6);
  if (g.size[2] < 3)
    throw Error(ErrorCode::InvalidArgument,
                "Fewer than three slices fit into the volume: make them thinner.");
  g.origin = g.indexToWorld()({0, 0, 0.5 * (c.thickness / voxel - 1)});
  g.spacing[2] = distance;
  if (pixel > 0) g = withPixels(g, pixel);
  stack.thickness = c.thickness;
  stack.profile = SliceProfile::Box;
  stack.image.voxels.resize(static_cast<std::size_t>(g.voxelCount()));
  return stack;
}

/// The middle of slice k, or of its packet.
Vec3 turningCentre(const GridGeometry& g, std::int64_t k, std::int64_t packets) {
  const std::int64_t last = packets > 0 ? g.size[2] - 1 - (g.size[2] - 1 - k) % packets : k;
  return g.indexToWorld()({0.5 * static_cast<double>(g.size[0] - 1), 0.5 * static_cast<double>(g.size[1] - 1),
                           0.5 * static_cast<double>(k + last)});
}

/// A rigid motion by up to what the case says.
Affine3 randomPose(const StacksCase& c, const Vec3& centre, const std::function<double()>& even) {
  Vec3 shift, turn;
  for (int a = 0; a < 3; ++a)
    shift[a] = c.motion * even();
  for (int a = 0; a < 3; ++a)
    turn[a] = c.turn * std::numbers::pi / 180 * even();
  return c.motion > 0 || c.turn > 0 ? rigidAbout(centre, turn, shift) : Affine3{};
}

/// 1 ± up to `amount`: a polynomial of second degree over the stack's box.
struct Shading {
  std::array<double, 9> coefficient{};
  double most = 1, amount;

  Shading(double share, Random& random) : amount(share) {
    for (double& c : coefficient)
      c = 2 * random.uniform() - 1;
    most = 0;
    for (int n = 0; n < 9 * 9 * 9; ++n)
      most = std::max(most, std::abs(polynomial({n % 9 / 4.0 - 1, n / 9 % 9 / 4.0 - 1, n / 81 / 4.0 - 1})));
  }
  double polynomial(const Vec3& x) const {
    const double terms[9] = {x[0],        x[1],        x[2],        x[0] * x[0], x[1] * x[1],
                             x[2] * x[2], x[0] * x[1], x[1] * x[2], x[2] * x[0]};
    double sum = 0;
    for (int t = 0; t < 9; ++t)
      sum += coefficient[t] * terms[t];
    return sum;
  }
  double at(const Vec3& x) const { return 1 + amount * polynomial(x) / most; }
};

/// The tissue at the points of a grid, averaged around each.
std::vector<float> averagedInPlane(const ItkCubic& tissue, const GridGeometry& grid,
                                   const ProfileQuadrature& within, ThreadPool& pool) {
  std::vector<float> sum(static_cast<std::size_t>(grid.voxelCount()), 0.f);
  GridGeometry moved = grid;
  for (const PixelPoint& point : pixelPoints(within, grid.spacing)) {
    moved.origin = grid.indexToWorld()({point.offset[0], point.offset[1], 0});
    const std::vector<float> values = tissue.on(moved, pool);
    const auto weight = static_cast<float>(point.weight);
    for (std::size_t v = 0; v < sum.size(); ++v)
      sum[v] += weight * values[v];
  }
  return sum;
}

} // namespace

SimulatedStacks simulateStacks(const Volume& volume, const StacksCase& c, ThreadPool& pool) {
  checkGeometry(volume.geometry, "The volume");
  checkCase(c, volume.geometry);
  SimulatedStacks result;
  result.truth = middleOf(volume, c.central);
  const ItkCubic tissue(volume);
  constexpr Plane planes[] = {Plane::Axial, Plane::Coronal, Plane::Sagittal};
  for (int s = 0; s < c.stacks; ++s) {
    const int axis = sliceAxis(result.truth.geometry, planes[s]);
    const double pixel = static_cast<std::size_t>(s) < c.pixels.size() ? c.pixels[s] : 0;
    Stack stack = emptyStack(result.truth.geometry, axis, c, pixel);
    stack.name = planeName(planes[s]);
    const GridGeometry& g = stack.image.geometry;
    Random random(c.seed + 1000 * static_cast<std::uint64_t>(s + 1));
    const auto even = [&] { return 2 * random.uniform() - 1; };
    const Shading shading(c.shading, random);
    Vec3 scale, offset{-1, -1, -1};
    for (int a = 0; a < 3; ++a)
      scale[a] = 2 / static_cast<double>(g.size[a] - 1);
    const Affine3 toBox = Affine3{diagonal(scale), offset} * inverse(g.indexToWorld());
    result.shading.push_back([shading, toBox](const Vec3& x) { return shading.at(toBox(x)); });
    const ProfileQuadrature planesOf =
        profileQuadrature(SliceProfile::Box, c.thickness, result.truth.geometry.spacing[axis]);
    const ProfileQuadrature within =
        profileQuadrature(SliceProfile::Box, pixel, result.truth.geometry.spacing[0]);
    const auto count = static_cast<std::int64_t>(planesOf.offset.size());
    const std::int64_t plane = g.size[0] * g.size[1];
    const Affine3 map = g.indexToWorld();
    auto& poses = result.poses.emplace_back();
    for (std::int64_t k = 0; k < g.size[2]; ++k) {
      const bool follows = c.motionPackets > 0 && k >= c.motionPackets;
      const Affine3 pose = follows ? poses[static_cast<std::size_t>(k % c.motionPackets)]
                                   : randomPose(c, turningCentre(g, k, c.motionPackets), even);
      poses.push_back(pose);
      GridGeometry seen = g; // the planes within this slice
      seen.size[2] = count;
      seen.spacing[2] = count > 1 ? planesOf.offset[1] - planesOf.offset[0] : 1;
      seen.origin =
          pose(g.indexToWorld()({0, 0, static_cast<double>(k) + planesOf.offset[0] / g.spacing[2]}));
      seen.direction = pose.linear * g.direction;
      const std::vector<float> thin = averagedInPlane(tissue, seen, within, pool);
      const double gain = 1 + c.gain * even();
      for (std::int64_t p = 0; p < plane; ++p) {
        double sum = 0;
        for (std::int64_t q = 0; q < count; ++q)
          sum += planesOf.weight[q] * thin[static_cast<std::size_t>(q * plane + p)];
        const Vec3 at = map(
            {static_cast<double>(p % g.size[0]), static_cast<double>(p / g.size[0]), static_cast<double>(k)});
        stack.image.voxels[static_cast<std::size_t>(k * plane + p)] =
            static_cast<float>(sum * gain * result.shading.back()(at));
      }
    }
    if (c.noise > 0) addNoise(stack.image.voxels, c.noise, c.seed + static_cast<std::uint64_t>(s));
    if (c.interpolated && pixel > 0) {
      const GridGeometry fine = emptyStack(result.truth.geometry, axis, c, 0).image.geometry;
      stack.image = {fine, ItkCubic(stack.image).on(fine, pool)};
    }
    result.stacks.push_back(std::move(stack));
  }
  return result;
}

} // namespace innergs
