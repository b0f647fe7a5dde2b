#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Model/GaussianField.h"

#include <string>

namespace innergs::bench {

/// The paper's number: an even grid of 42³.
constexpr std::int64_t kPaperGaussians = 74088;
/// Iterations that the scene's field was fitted for: gives typical sizes and orientations of Gaussians during
/// a fit.
constexpr int kSceneIterations = 40;

/// The data of the micro-benchmarks: a volume, and kPaperGaussians fitted to it for kSceneIterations.
struct Scene {
  Stack stack;
  GaussianField field;
  IntensityMap map; // of the field
};

/// Created at the first call. Without a volume: a synthetic head of 145×174×145 voxels.
const Scene& scene();
/// The same with alpha blending, fitted to the slices of all axes.
const Scene& alphaScene();
void setSceneVolume(const std::string& path); // before the first call
std::string sceneName();

/// The field on the volume's own grid.
SampleGrid sceneGrid();

} // namespace innergs::bench
