#include "JobInputs.h"

#include <cstdlib>

using namespace innergs;
using namespace innergs::testing;

namespace {

struct Case {
  const char* name;
  ReconstructionInput (*input)();
  Blending blending;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}
const Case kCases[] = {{"Isotropic", isotropicInput, Blending::Normalised},
                       {"ThickSlices", anisotropicInput, Blending::Normalised},
                       {"TwoStacks", orthogonalInput, Blending::Normalised},
                       {"Additive", isotropicInput, Blending::Additive},
                       {"Alpha", isotropicInput, Blending::Alpha}};

/// Whole reconstructions through the plugin loader, with the kernels on the host executor.
class Jobs : public ::testing::TestWithParam<Case> {
protected:
  static void SetUpTestSuite() {
#ifdef _WIN32
    _putenv_s("INNERGS_PLUGIN_PATH", INNERGS_HOST_PLUGIN);
#else
    setenv("INNERGS_PLUGIN_PATH", INNERGS_HOST_PLUGIN, 1);
#endif
  }
};

} // namespace

TEST_P(Jobs, GiveTheVolumeOfTheCpu) {
  Settings settings = quickSettings(16);
  settings.blending = GetParam().blending;
  settings.threads = 1;
  const auto cpu = reconstruct(GetParam().input(), settings);
  settings.device = "cuda:0";
  const auto device = reconstruct(GetParam().input(), settings);
  EXPECT_EQ(device.device.name, "Host executor");
  EXPECT_EQ(device.device.id, "cuda:0");
  EXPECT_TRUE(device.warnings == cpu.warnings);
  EXPECT_EQ(device.iterations, cpu.iterations);
  EXPECT_NEAR(device.trainingPsnr, cpu.trainingPsnr, 0.05);
  ASSERT_EQ(device.volume.voxels.size(), cpu.volume.voxels.size());
  EXPECT_GT(psnr(device.volume, cpu.volume), cpu.trainingPsnr + 6);
}

INSTANTIATE_TEST_SUITE_P(OnTheHostExecutor, Jobs, ::testing::ValuesIn(kCases),
                         [](const auto& info) { return info.param.name; });
