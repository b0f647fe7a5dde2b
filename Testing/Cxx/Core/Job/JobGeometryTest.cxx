#include "Core/Job/JobInput.h"
#include "Core/Render/Render.h"
#include "JobInputs.h"
#include "ThrownError.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A bright blob on a faint slope: σ 2.4 mm.
double blob(const Vec3& x, const Vec3& at) {
  const Vec3 d = x - at;
  return 200 * std::exp(-0.5 * dot(d, d) / (2.4 * 2.4));
}

/// Centre of mass (LPS mm) of the voxels brighter than a fifth of the maximum.
Vec3 centreOfMass(const Volume& volume) {
  const double floor = 0.2 * *std::max_element(volume.voxels.begin(), volume.voxels.end());
  const Affine3 map = volume.geometry.indexToWorld();
  Vec3 sum{0, 0, 0};
  double total = 0;
  for (std::int64_t v = 0; v < volume.geometry.voxelCount(); ++v) {
    const double value = volume.voxels[v] - floor;
    if (value <= 0) continue;
    const auto& n = volume.geometry.size;
    sum = sum + value * map({double(v % n[0]), double(v / n[0] % n[1]), double(v / n[0] / n[1])});
    total += value;
  }
  return (1 / total) * sum;
}

} // namespace

/// Rotation angle, left-handed.
class Landmark : public ::testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(Landmark, StaysAtItsPlaceInPatientSpace) {
  const auto [angle, leftHanded] = GetParam();
  const GridGeometry scan =
      grid(26, 24, 22, {1.1, 0.9, 1.3}, {40, -70, 33}, obliqueDirection(angle, leftHanded));
  const Vec3 at = scan.indexToWorld()({9.3, 14.6, 8.2});
  ReconstructionInput input =
      inputOf({pointStack(volumeInSpace(scan, [&](const Vec3& x) { return blob(x, at); }))});
  // Another orientation, handedness and spacing.
  GridGeometry output =
      grid(30, 28, 26, {0.9, 1.0, 1.1}, {0, 0, 0}, obliqueDirection(angle + 0.8, !leftHanded));
  output.origin = at - output.direction * Vec3{12.7, 15, 14.1};
  input.outputGrid = output;
  const auto result = reconstruct(input, quickSettings(60));
  ASSERT_TRUE(result.volume.geometry == output);
  const Vec3 found = centreOfMass(result.volume);
  EXPECT_LT(norm(found - at), 0.05) << "mm, of voxels of 0.9 to 1.3 mm";
  // By default over the scan's own box, at its finest spacing.
  input.outputGrid.reset();
  const auto own = reconstruct(input, quickSettings(60));
  EXPECT_NEAR(own.volume.geometry.spacing[0], 0.9, 1e-9);
  EXPECT_LT(norm(centreOfMass(own.volume) - at), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Grids, Landmark, ::testing::Combine(::testing::Values(0.0, 0.9), ::testing::Bool()));

TEST(Landmark, OfThickSlicesStaysInPlace) {
  const GridGeometry fine = grid(28, 28, 28, {1, 1, 1}, {12, 8, -30}, obliqueDirection(0.7, true));
  const Vec3 at = fine.indexToWorld()({13.3, 14.6, 12.2});
  const Volume truth = volumeInSpace(fine, [&](const Vec3& x) { return blob(x, at); });
  ReconstructionInput single = inputOf({simulateThickStack(truth, 2, 4)}),
                      crossed = inputOf({simulateThickStack(truth, 2, 4), simulateThickStack(truth, 0, 4)});
  for (ReconstructionInput* input : {&single, &crossed}) {
    input->outputGrid = fine;
    Settings settings = quickSettings(60);
    settings.gaussians = 600;
    const Vec3 off = transpose(fine.direction) * (centreOfMass(reconstruct(*input, settings).volume) - at);
    EXPECT_NEAR(off[0], 0, 0.1); // mm, in-plane: voxels of 1 mm
    EXPECT_NEAR(off[1], 0, 0.1);
    EXPECT_NEAR(off[2], 0, 0.2); // across: slices of 4 mm
  }
}

namespace {

struct Posed {
  const char* name;
  int permutation[12];
  double angle, shift; // of a rigid motion of every slice, varying between slices
  bool together;       // the same motion for all
};

} // namespace

class Poses : public ::testing::TestWithParam<Posed> {};

TEST_P(Poses, ReconstructTheSameVolumeFromDisplacedSlices) {
  const GridGeometry geometry = grid(22, 20, 12, {1, 1, 1.2}, {5, -7, 11}, obliqueDirection(0.4));
  const auto anatomy = [](const Vec3& x) {
    return 100 + 60 * std::sin(0.3 * x[0]) * std::cos(0.25 * x[1]) + 40 * std::sin(0.35 * x[2]);
  };
  const Stack stack = pointStack(volumeInSpace(geometry, anatomy));
  ReconstructionInput plain = inputOf({stack});
  plain.outputGrid = geometry;

  // Slice k of the file shows the plane of slice permutation[k], slightly moved.
  ReconstructionInput posed = plain;
  Stack& moved = posed.stacks[0];
  const Vec3 normal = column(geometry.direction, 2), centre = geometry.centre();
  for (int k = 0; k < 12; ++k) {
    const int to = GetParam().permutation[k];
    const double sign = GetParam().together ? 1 : std::cos(2.0 * k);
    Affine3 motion{obliqueDirection(GetParam().angle * sign), {0, 0, 0}};
    motion.offset = centre - motion.linear * centre + (GetParam().shift * sign) * Vec3{0.6, -0.64, 0.48};
    const Affine3 pose = motion * Affine3{Mat3{}, 1.2 * (to - k) * normal};
    moved.poses.push_back(pose);
    moved.times.push_back(0.1 * k);
    const Affine3 map = pose * geometry.indexToWorld();
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 22; ++i)
        moved.image.voxels[i + 22 * (j + 20 * k)] =
            static_cast<float>(anatomy(map({double(i), double(j), double(k)})));
  }
  Settings settings = quickSettings(80);
  settings.consistency = false; // posed slices get no residual grid
  settings.gaussians = 500;
  const auto a = reconstruct(plain, settings), b = reconstruct(posed, settings);
  const double plainPsnr = psnr(a.volume, stack.image), posedPsnr = psnr(b.volume, stack.image);
  EXPECT_GT(plainPsnr, 45);
  EXPECT_GT(posedPsnr, 45); // moved slices leave corners of the grid uncovered
  // Each slice shows the field through its pose.
  const Volume seen = renderStack(b.model->field, moved);
  EXPECT_GT(psnr(seen, moved.image), plainPsnr - 3);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Poses,
    ::testing::Values(Posed{"NoMotion", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 0, 0, true},
                      Posed{"Jitter", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 0.04, 0.5, false},
                      Posed{"Interleaved", {0, 2, 4, 6, 8, 10, 1, 3, 5, 7, 9, 11}, 0, 0, true},
                      Posed{"Shuffled", {7, 2, 11, 0, 9, 4, 1, 10, 5, 8, 3, 6}, 0.02, 0.3, false}),
    [](const auto& info) { return std::string(info.param.name); });

namespace {

/// Slices [first, first + count) of a scan, as a separate scan.
Stack slab(const Volume& scan, std::int64_t first, std::int64_t count) {
  Stack stack;
  stack.profile = SliceProfile::Point;
  GridGeometry& g = stack.image.geometry = scan.geometry;
  g.origin = scan.geometry.indexToWorld()({0, 0, double(first)});
  g.size[2] = count;
  const std::int64_t plane = g.size[0] * g.size[1];
  stack.image.voxels.assign(scan.voxels.begin() + first * plane,
                            scan.voxels.begin() + (first + count) * plane);
  return stack;
}

} // namespace

// Slices 0 to 5, 6 to 11 (adjoining), 13 to 19 (a slice is missing between them).
TEST(Slabs, OfOneAcquisitionInAnyOrderAreReconstructedAsOne) {
  const GridGeometry whole = grid(22, 20, 20, {1, 1, 1.5}, {-30, 12, 5}, obliqueDirection(0.3, true));
  const Volume truth = phantom(whole);
  const std::vector<Stack> slabs{slab(truth, 0, 6), slab(truth, 6, 6), slab(truth, 13, 7)};
  std::array<int, 3> order{0, 1, 2};
  do {
    ReconstructionInput input;
    for (const int n : order)
      input.stacks.push_back(slabs[n]);
    const GridGeometry all = acquisitionGrid(input.stacks);
    EXPECT_EQ(all.size, whole.size);
    EXPECT_LT(norm(all.origin - whole.origin), 1e-9);
    EXPECT_NO_THROW(prepareInput(input));
  } while (std::next_permutation(order.begin(), order.end()));

  ReconstructionInput input;
  input.stacks = {slabs[2], slabs[0], slabs[1]};
  Settings settings = quickSettings(60);
  settings.gaussians = 800;
  const Volume result = reconstruct(input, settings).volume;
  EXPECT_NEAR(result.geometry.extent()[2], whole.extent()[2], 1);
  Volume sampled{whole, std::vector<float>(truth.voxels.size())};
  const Affine3 map = inverse(result.geometry.indexToWorld()) * whole.indexToWorld();
  for (std::int64_t v = 0; v < whole.voxelCount(); ++v)
    sampled.voxels[v] = static_cast<float>(
        sampleLinear(result, map({double(v % 22), double(v / 22 % 20), double(v / 22 / 20)})));
  EXPECT_GT(psnr(sampled, truth), 26);
}

TEST(Slabs, FurtherApartAreRefused) {
  const Volume truth = phantom(grid(22, 20, 20, {1, 1, 1.5}, {-30, 12, 5}, obliqueDirection(0.3)));
  ReconstructionInput input;
  input.stacks = {slab(truth, 0, 6), slab(truth, 8, 6)}; // two slices are missing
  const Error error = test::errorOf([&] { prepareInput(input); });
  EXPECT_EQ(error.code(), ErrorCode::Geometry);
  EXPECT_TRUE(test::contains(error, "Stack 2 does not overlap Stack 1")) << error.what();
}

TEST(Poses, FarFromTheFilesOwnGeometry) {
  // The whole scan lies 200 mm from where the file's grid places it.
  ReconstructionInput plain = isotropicInput(), posed = plain;
  const Vec3 shift{120, -160, 0};
  plain.outputGrid = smallGrid();
  posed.outputGrid = smallGrid();
  posed.stacks[0].image.geometry.origin = smallGrid().origin - shift;
  posed.stacks[0].poses.assign(20, Affine3{Mat3{}, shift});
  const GridGeometry covering = defaultOutputGrid(posed.stacks), usual = defaultOutputGrid(plain.stacks);
  EXPECT_EQ(covering.size, usual.size); // only where slices lie
  EXPECT_LT(norm(covering.origin - usual.origin), 1e-9);
  Settings settings = quickSettings(40);
  settings.consistency = false; // posed slices get no residual grid
  const auto a = reconstruct(plain, settings), b = reconstruct(posed, settings);
  const Volume truth = phantom(smallGrid());
  // Posed slices coarsen one by one, so the two fits diverge; a misplaced scan would end near 10 dB.
  EXPECT_GT(psnr(b.volume, truth), 28);
  EXPECT_GT(psnr(b.volume, truth), psnr(a.volume, truth) - 4);
}
