// Scans that show something else than the others do, towards the edges of the narrower one.
#include "Core/Alignment/EdgeBlending.h"
#include "../JobInputs.h"
#include "HeadPhantom.h"

#include <numeric>

namespace innergs {
namespace {

/// A scan of one value: n³ voxels of 1 mm from a corner on.
Stack even(std::int64_t n, double corner, float value) {
  Stack scan;
  scan.image.geometry.size = {n, n, n};
  scan.image.geometry.origin = {corner, corner, corner};
  scan.image.voxels.assign(static_cast<std::size_t>(n * n * n), value);
  return scan;
}

void blend(std::vector<Stack>& scans, double width) {
  ThreadPool pool(2);
  std::vector<std::size_t> all(scans.size());
  std::iota(all.begin(), all.end(), 0);
  blendEdges(scans, all, width, pool);
}

float along(const Stack& scan, std::int64_t k) { // through the middle
  const auto& n = scan.image.geometry.size;
  return scan.image.voxels[static_cast<std::size_t>((k * n[1] + n[1] / 2) * n[0] + n[0] / 2)];
}

TEST(EdgeBlending, LeadsFromOneScanToTheOther) {
  std::vector<Stack> scans{even(60, 0, 100), even(30, 15, 200)};
  const Stack wide = scans[0];
  blend(scans, 10);
  EXPECT_EQ(scans[0].image.voxels, wide.image.voxels) << "it ends where there is no other";
  for (std::int64_t k = 0; k < 10; ++k) { // the middles of the voxels lie k + 0.5 mm inside
    EXPECT_NEAR(along(scans[1], k), 100 + 10 * (static_cast<double>(k) + 0.5), 1e-3);
    EXPECT_NEAR(along(scans[1], 29 - k), along(scans[1], k), 1e-3);
  }
  EXPECT_EQ(along(scans[1], 15), 200);
}

TEST(EdgeBlending, LeavesScansThatEndTogether) {
  std::vector<Stack> scans{even(30, 0, 100), even(30, 0, 200)};
  const std::vector<Stack> before = scans;
  blend(scans, 10);
  for (int s = 0; s < 2; ++s)
    EXPECT_EQ(scans[s].image.voxels, before[s].image.voxels);
}

TEST(EdgeBlending, ReadsObservedVoxelsAlone) {
  std::vector<Stack> scans{even(60, 0, 100), even(30, 15, 200)};
  scans[0].observed.assign(scans[0].image.voxels.size(), 0);
  std::vector<Stack> before = scans;
  blend(scans, 10);
  EXPECT_EQ(scans[1].image.voxels, before[1].image.voxels);
  scans[0].observed.clear();
  scans[0].poses.assign(60, {});
  blend(scans, 10);
  EXPECT_EQ(scans[1].image.voxels, before[1].image.voxels) << "nor scans with poses";
}

/// An axial scan and the middle of a coronal one, shaded otherwise.
ReconstructionInput slabIn(const Volume& head, double shading) {
  ReconstructionInput input =
      testing::inputOf({simulateThickStack(head, 2, 4, 1, 1), simulateThickStack(head, 1, 4, 1, 2)});
  Stack& slab = input.stacks[1];
  GridGeometry& g = slab.image.geometry; // its slices are counted along K
  const std::int64_t plane = g.size[0] * g.size[1], cut = g.size[2] / 4;
  g.origin = g.indexToWorld()({0, 0, static_cast<double>(cut)});
  g.size[2] -= 2 * cut;
  slab.image.voxels = {slab.image.voxels.begin() + cut * plane,
                       slab.image.voxels.begin() + (cut + g.size[2]) * plane};
  for (std::size_t v = 0; v < slab.image.voxels.size(); ++v) {
    const double x =
        static_cast<double>(static_cast<std::int64_t>(v) % g.size[0]) / static_cast<double>(g.size[0]);
    slab.image.voxels[v] *= static_cast<float>(1 + shading * (2 * x - 1));
  }
  input.outputGrid = head.geometry;
  return input;
}

/// How much what the shading changes differs between two neighbouring planes in the head, root mean square.
double step(const Volume& shaded, const Volume& plain, const Volume& head, std::int64_t j) {
  const std::int64_t n = head.geometry.size[0];
  double squares = 0, count = 0;
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t i = 0; i < n; ++i) {
      const auto a = static_cast<std::size_t>((k * n + j - 1) * n + i), b = a + static_cast<std::size_t>(n);
      if (head.voxels[a] == 0 || head.voxels[b] == 0) continue;
      squares += std::pow((shaded.voxels[a] - plain.voxels[a]) - (shaded.voxels[b] - plain.voxels[b]), 2);
      ++count;
    }
  return std::sqrt(squares / count);
}

TEST(EdgeBlending, LeavesNoStepWhereAScanEnds) {
  const Volume head = testing::headPhantom(48);
  const auto fit = [&](double shading, bool blended) {
    Settings settings = testing::fastSettings();
    settings.blendEdges = blended;
    settings.sliceMotion = SliceMotionKind::Off;
    return testing::reconstruct(slabIn(head, shading), settings).volume;
  };
  const Volume plain = fit(0, false), off = fit(0.4, false), on = fit(0.4, true);
  for (const std::int64_t face : {12, 36})
    EXPECT_LT(step(on, plain, head, face), 0.65 * step(off, plain, head, face)) << face;
  EXPECT_EQ(fit(0, true).voxels, plain.voxels) << "scans that agree stay as they are";
}

} // namespace
} // namespace innergs
