#include "Scene.h"

#include "Core/Base/Error.h"
#include "Core/Base/Random.h"
#include "Core/Job/ReconstructionJob.h"
#ifdef INNERGS_BENCHMARK_READS_VOLUMES
#include "IO/VolumeIO.h"
#endif

#include <cmath>
#include <filesystem>
#include <numbers>

namespace innergs::bench {
namespace {

double edge(double x) {
  return 1 / (1 + std::exp(-x));
} // of a tissue, about a voxel wide

/// Scalp, skull, folded cortex around white matter, ventricles, and 3 % noise: structure at all scales, as in
/// a T1 head.
double headIntensity(double x, double y, double z) {
  const double r = std::sqrt(x * x + y * y + z * z), sharp = 70;
  const double fold =
      0.045 * (std::sin(23 * x + 3 * z) * std::sin(21 * y) + std::sin(25 * z + 4 * y) * std::cos(19 * x));
  const double vein = 0.02 * std::sin(51 * x) * std::sin(47 * y) * std::sin(49 * z);
  double value = 0;
  const auto fill = [&](double inside, double intensity) { value += inside * (intensity - value); };
  fill(edge(sharp * (0.97 - r)), 170);                           // scalp
  fill(edge(sharp * (0.90 - r)), 25);                            // skull
  fill(edge(sharp * (0.85 - r)), 45);                            // cerebrospinal fluid
  fill(edge(sharp * (0.80 + fold - r)), 105 + 300 * vein);       // grey matter
  fill(edge(sharp * (0.70 + 1.6 * fold - r)), 150 + 150 * vein); // white matter
  const double ventricle = std::hypot((std::abs(x) - 0.1) / 0.07, y / 0.3, z / 0.12);
  fill(edge(6 * (1 - ventricle)), 40);
  return value;
}

Volume syntheticHead() {
  Volume head;
  head.geometry.size = {145, 174, 145};
  head.geometry.spacing = {1.25, 1.25, 1.25};
  head.voxels.reserve(static_cast<std::size_t>(head.geometry.voxelCount()));
  Random random(1);
  const auto& n = head.geometry.size;
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const double truth =
            headIntensity((i - 0.5 * (n[0] - 1)) / (0.47 * n[0]), (j - 0.5 * (n[1] - 1)) / (0.47 * n[1]),
                          (k - 0.5 * (n[2] - 1)) / (0.47 * n[2]));
        const double radius = 6 * std::sqrt(-2 * std::log(1 - random.uniform())); // Box-Muller
        const double angle = 2 * std::numbers::pi * random.uniform();
        head.voxels.push_back(
            static_cast<float>(std::hypot(truth + radius * std::cos(angle), radius * std::sin(angle))));
      }
  return head;
}

std::string volumeFile; // empty: the synthetic head

Volume sceneVolume() {
  if (volumeFile.empty()) return syntheticHead();
#ifdef INNERGS_BENCHMARK_READS_VOLUMES
  return readVolume(volumeFile);
#else
  throw Error(ErrorCode::InvalidArgument,
              "This build cannot read images: set INNERGS_BUILD_IO or give no volume.");
#endif
}

Scene makeScene(Blending blending) {
  Scene scene;
  scene.stack.image = sceneVolume();
  scene.stack.profile = SliceProfile::Point;
  scene.stack.thickness = scene.stack.image.geometry.spacing[2];
  ReconstructionInput input;
  input.stacks = {scene.stack};
  Settings settings;
  settings.blending = blending;
  settings.gaussians = kPaperGaussians;
  settings.iterations = kSceneIterations;
  settings.ensembleSize = 1;
  scene.field = ReconstructionJob(std::move(input), settings).run().model->field;
  scene.map = {scene.field.intensityScale, scene.field.intensityOffset};
  return scene;
}

} // namespace

const Scene& scene() {
  static const Scene made = makeScene(Blending::Normalised);
  return made;
}

const Scene& alphaScene() {
  static const Scene made = makeScene(Blending::Alpha);
  return made;
}

void setSceneVolume(const std::string& path) {
  volumeFile = path;
}

std::string sceneName() {
  return volumeFile.empty() ? "synthetic head" : std::filesystem::path(volumeFile).filename().string();
}

SampleGrid sceneGrid() {
  return sampleGridOf(scene().stack.image.geometry, scene().field.modelToWorld);
}

} // namespace innergs::bench
