#pragma once
#include "Core/Acquisition/Observation.h"
#include "Cuda/Executor.h"
#include "Cuda/Fit.h"

#include <cmath>
#include <functional>
#include <string>

/// What the CUDA benchmark measures, on the device or, to try it, with the host executor.
namespace innergs::bench {

double median(std::vector<double> values);

struct Options {
  std::string volume, output;
  bool host = false;
  int repeats = 7;
};

/// One size for the device, another to try it all on the host.
struct Sizes {
  std::int64_t gaussians = 74088;
  int jobIterations = 0; // 0: the preset's
  std::int64_t large = 512;
  int largeEdge = 126; // Gaussians along an edge of it
  int plane = 512;
};

std::unique_ptr<cuda::Executor> executorOf(const Options& options);
/// Smooth waves between 20 and 180, where no volume is given.
Volume waves(std::int64_t nx, std::int64_t ny, std::int64_t nz);

struct JobRun {
  double toPaper = NAN, seconds = 0, fitSeconds = 0, psnr = 0, firstIteration = NAN;
  int iterations = 0;
  std::string device;
};

constexpr double kPaperPsnr = 32.47;
/// A whole reconstruction with every voxel of the volume, preset balanced.
JobRun job(const Volume& volume, const Sizes& sizes, const std::string& device, int threads);

/// A field in the middle of its fit, and what it is fitted to.
struct Scene {
  GaussianField field;
  std::vector<Observation> observations;
};

Scene sceneOf(const Volume& volume, const Sizes& sizes, Blending blending);
FitRequest requestOf(const Scene& scene);

/// Seconds an iteration of a fit, in runs with one wait as jobs do them. Learning rates of 0 keep the field.
double iterationSeconds(cuda::Fit& fit, const GaussianField& field, int repeats, int relocateEvery = 0);
double cpuIterationSeconds(const Scene& scene, int threads, int repeats);
/// Seconds an iteration over a large volume with Gaussians on an even grid, as many as are given back.
double largeIteration(const Options& options, const Sizes& sizes, std::int64_t& gaussians);
/// An oblique plane through the middle of the volume, copied to host memory.
double planeMilliseconds(const Options& options, const Sizes& sizes, const Scene& scene,
                         const Volume& volume);

} // namespace innergs::bench
