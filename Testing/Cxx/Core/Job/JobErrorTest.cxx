#include "JobInputs.h"
#include "ThrownError.h"

#include "Core/Base/SystemMemory.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Settings/SettingsTable.h"

#include <cmath>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// The error that a run ends with; it must be a single sentence on one line.
ErrorCode errorOf(const ReconstructionInput& input, const Settings& settings = quickSettings(2)) {
  bool fitted = false;
  ReconstructionJob job(input, settings);
  job.onProgress([&](const Progress& p) { fitted |= p.phase == Phase::Fitting; });
  try {
    job.run();
  } catch (const Error& error) {
    const std::string sentence = error.what();
    EXPECT_GT(sentence.size(), 15u) << sentence;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    EXPECT_EQ(sentence.back(), '.') << sentence;
    EXPECT_FALSE(fitted) << "found before any work: " << sentence;
    return error.code();
  }
  ADD_FAILURE() << "accepted";
  return ErrorCode::Internal;
}

const double kNaN = std::numeric_limits<double>::quiet_NaN();

} // namespace

TEST(JobInput, WithoutImagesIsRefused) {
  EXPECT_EQ(errorOf({}), ErrorCode::InvalidArgument);
}

TEST(JobInput, OfASingleSliceIsRefused) {
  ReconstructionInput input;
  Stack stack;
  stack.image = phantom(grid(10, 10, 1));
  input.stacks.push_back(stack);
  EXPECT_EQ(errorOf(input), ErrorCode::UnsupportedImage);
}

TEST(JobInput, WithoutFiniteVoxelsIsRefused) {
  ReconstructionInput input = isotropicInput();
  std::fill(input.stacks[0].image.voxels.begin(), input.stacks[0].image.voxels.end(),
            static_cast<float>(kNaN));
  EXPECT_EQ(errorOf(input), ErrorCode::NoData);
}

TEST(JobInput, WithAnEmptyOrDistantMaskIsRefused) {
  ReconstructionInput input = isotropicInput();
  input.masks = {Mask{smallGrid(), std::vector<std::uint8_t>(smallGrid().voxelCount(), 0)}};
  EXPECT_EQ(errorOf(input), ErrorCode::NoData);
  std::fill(input.masks.front().voxels.begin(), input.masks.front().voxels.end(), std::uint8_t{1});
  input.masks.front().geometry.origin[0] += 500;
  EXPECT_EQ(errorOf(input), ErrorCode::NoData);
}

TEST(JobInput, WithMasksThatDoNotMatchItsScansIsRefused) {
  ReconstructionInput input = orthogonalInput();
  const Mask whole{smallGrid(), std::vector<std::uint8_t>(smallGrid().voxelCount(), 1)};
  input.masks = {whole, whole, whole};
  EXPECT_EQ(errorOf(input), ErrorCode::InvalidArgument) << "three for two scans";
  Mask empty = whole;
  std::fill(empty.voxels.begin(), empty.voxels.end(), std::uint8_t{0});
  input.masks = {whole, empty};
  EXPECT_EQ(errorOf(input), ErrorCode::NoData) << "although the other scan has voxels inside its own";
}

TEST(JobInput, OfAMaskOnBrokenVoxelsOnlyIsRefused) {
  ReconstructionInput input = isotropicInput();
  input.masks = {Mask{smallGrid(), std::vector<std::uint8_t>(smallGrid().voxelCount(), 0)}};
  for (int v : {100, 101, 102}) {
    input.masks.front().voxels[v] = 1;
    input.stacks[0].image.voxels[v] = static_cast<float>(kNaN);
  }
  EXPECT_EQ(errorOf(input), ErrorCode::NoData);
}

TEST(JobInput, OfStacksThatDoNotOverlapIsRefused) {
  ReconstructionInput input = orthogonalInput();
  input.stacks[1].image.geometry.origin[1] += 300;
  EXPECT_EQ(errorOf(input), ErrorCode::Geometry);
}

TEST(JobInput, OfAnOutputGridElsewhereIsRefused) {
  ReconstructionInput input = isotropicInput();
  input.outputGrid = smallGrid();
  input.outputGrid->origin[2] -= 900;
  EXPECT_EQ(errorOf(input), ErrorCode::Geometry);
  input.outputGrid = smallGrid();
  input.outputGrid->spacing[0] = 0;
  EXPECT_EQ(errorOf(input), ErrorCode::Geometry);
  input.outputGrid = smallGrid();
  input.outputGrid->size[1] = 0;
  EXPECT_EQ(errorOf(input), ErrorCode::Geometry);
}

TEST(JobInput, OfBrokenGeometryIsRefused) {
  const auto codeAfter = [](auto&& change) {
    ReconstructionInput input = isotropicInput();
    change(input.stacks[0]);
    return errorOf(input);
  };
  EXPECT_EQ(codeAfter([](Stack& s) { s.image.geometry.spacing[1] = -1; }), ErrorCode::Geometry);
  EXPECT_EQ(codeAfter([](Stack& s) { s.image.geometry.spacing[1] = kNaN; }), ErrorCode::Geometry);
  EXPECT_EQ(codeAfter([](Stack& s) { s.image.geometry.direction[0] = {0, 0, 0}; }), ErrorCode::Geometry);
  EXPECT_EQ(codeAfter([](Stack& s) { s.image.geometry.direction[0][1] += 0.2; }), ErrorCode::Geometry);
  EXPECT_EQ(codeAfter([](Stack& s) { s.image.voxels.pop_back(); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(codeAfter([](Stack& s) { s.observed.assign(5, 1); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(codeAfter([](Stack& s) { s.observed.assign(s.image.voxels.size(), 0); }), ErrorCode::NoData);
  EXPECT_EQ(codeAfter([](Stack& s) { s.thickness = -1; }), ErrorCode::InvalidArgument);
  EXPECT_EQ(codeAfter([](Stack& s) { s.poses.resize(3); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(codeAfter([](Stack& s) { s.times.resize(3); }), ErrorCode::InvalidArgument);
  EXPECT_EQ(codeAfter([](Stack& s) {
              s.poses.resize(20);
              s.poses[4].linear = diagonal({2, 1, 1});
            }),
            ErrorCode::Geometry);
}

TEST(JobInput, WithAHeldOutFractionOutOfRangeIsRefused) {
  for (double fraction : {-0.1, -1e-300, 0.6, 1.0, kNaN}) {
    ReconstructionInput input = isotropicInput();
    input.heldOutFraction = fraction;
    EXPECT_EQ(errorOf(input), ErrorCode::InvalidArgument) << fraction;
  }
}

TEST(JobSettings, OutOfRangeAreRefused) {
  const auto refused = [](auto&& change) {
    Settings settings = quickSettings(2);
    change(settings);
    return errorOf(isotropicInput(), settings) == ErrorCode::InvalidArgument;
  };
  for (const Setting& row : settingsTable()) {
    if (row.type() != Setting::Type::Real && row.type() != Setting::Type::Integer) continue;
    const bool whole = row.type() == Setting::Type::Integer;
    const double low = whole ? row.range.lowest - 1 : std::nextafter(row.range.lowest, -INFINITY),
                 high = whole ? row.range.highest + 1 : std::nextafter(row.range.highest, INFINITY);
    for (const double x : {low, high, -double(INFINITY), double(INFINITY)})
      EXPECT_TRUE(refused([&](Settings& s) { row.setNumber(s, x); })) << row.name << " " << x;
    if (!whole) {
      EXPECT_TRUE(refused([&](Settings& s) { row.member.set(s, kNaN); })) << row.name;
    }
    for (const auto& [open, x] :
         {std::pair(row.range.open, row.range.lowest), {row.range.openHigh, row.range.highest}})
      EXPECT_TRUE(!open || refused([&, x = x](Settings& s) { row.setNumber(s, x); })) << row.name << " " << x;
  }
  EXPECT_TRUE(refused([](Settings& s) { s.maxGaussians = 299; })); // 300 at the start
  EXPECT_TRUE(refused([](Settings& s) { s.instructionSet = "MMX"; }));
  EXPECT_TRUE(refused([](Settings& s) {
    s.blending = Blending::Additive;
    s.linearIntensity = true;
  }));
  EXPECT_TRUE(refused([](Settings& s) {
    s.blending = Blending::Alpha;
    s.linearIntensity = true;
  }));
  EXPECT_TRUE(refused([](Settings& s) {
    s.preset = Preset::Paper; // alpha
    s.linearIntensity = true;
  }));
  EXPECT_TRUE(refused([](Settings& s) {
    s.blending = Blending::Alpha;
    s.ensembleSize = 2;
  }));
  EXPECT_TRUE(refused([](Settings& s) { s.lossWeight = 0; }));
}

TEST(JobMemory, ThatIsNotThereIsRefusedWithTheNumbers) {
  if (availableMemory() == 0) GTEST_SKIP() << "this system does not say how much memory is available";
  ReconstructionInput input = isotropicInput();
  input.outputGrid = withSpacing(smallGrid(), {1e-3, 1e-3, 1e-3}); // 10^13 voxels
  EXPECT_GT(estimateMemory(input, quickSettings(2)), availableMemory());
  EXPECT_EQ(errorOf(input), ErrorCode::Memory);
  EXPECT_TRUE(test::contains(test::errorOf([&] { reconstruct(input, quickSettings(2)); }), "GB"));
  ReconstructionInput many = isotropicInput();
  Settings settings = quickSettings(2);
  settings.gaussians = 999'999'999;
  EXPECT_EQ(errorOf(many, settings), ErrorCode::Memory);
}

TEST(JobMemory, OfAlphaBlendingAndDensificationIsRefusedWithTheNumbers) {
  if (availableMemory() == 0) GTEST_SKIP() << "this system does not say how much memory is available";
  ReconstructionInput input = isotropicInput();
  Settings settings = quickSettings(2);
  settings.blending = Blending::Alpha;
  settings.maxGaussians = 999'999'999; // starts small and may grow beyond the available memory
  EXPECT_EQ(errorOf(input, settings), ErrorCode::Memory);
  settings.densifyEvery = 0; // it cannot grow
  EXPECT_LT(estimateMemory(input, settings), 200'000'000);
}

TEST(JobMemory, EstimateKnowsAllAxesAndWhatAlphaBlendingKeeps) {
  ReconstructionInput input;
  Stack stack;
  stack.image.geometry = grid(200, 210, 190);
  input.stacks.push_back(stack);
  const double voxels = 200.0 * 210 * 190;
  Settings one, three, alpha;
  one.gaussians = three.gaussians = alpha.gaussians = 100'000;
  one.consistency = three.consistency = false;
  one.linearIntensity = three.linearIntensity = false;
  three.allAxes = true;
  alpha.blending = Blending::Alpha;
  const double single = static_cast<double>(estimateMemory(input, one)),
               all = static_cast<double>(estimateMemory(input, three)),
               blended = static_cast<double>(estimateMemory(input, alpha));
  EXPECT_GT(all, single + 10 * voxels); // targets and weights of two more stacks
  EXPECT_LT(all, single + 30 * voxels);
  // σ about 2 voxels: ten planes and more, 32 bytes each, on three grids; 12 bytes per voxel of one.
  EXPECT_GT(blended, all + 12 * voxels + 100'000 * 3 * 32.0 * 10);
  EXPECT_LT(blended, all + 16 * voxels + 100'000 * 3 * 32.0 * 60);
}

TEST(JobMemory, EstimateGrowsWithTheWork) {
  const ReconstructionInput input = isotropicInput();
  Settings small = quickSettings(), large = quickSettings();
  large.gaussians = 1'000'000;
  EXPECT_GT(estimateMemory(input, small), 1'000'000);
  EXPECT_GT(estimateMemory(input, large), estimateMemory(input, small) + 200'000'000);
  ReconstructionInput finer = input;
  finer.outputGrid = withSpacing(smallGrid(), {0.1, 0.1, 0.1});
  EXPECT_GT(estimateMemory(finer, small), estimateMemory(input, small) + 30'000'000);
}
