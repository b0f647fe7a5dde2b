#pragma once
#include "Core/Acquisition/Observation.h"
#include "Cuda/Executor.h"
#include "Cuda/Fit.h"

#include <cmath>
#include <functional>
#include <string>

/// The measurements of the CUDA benchmark, on the device or, for a trial, with the host executor.
namespace innergs::bench {

double median(std::vector<double> values);

struct Options {
  std::string volume, output;
  bool host = false;
  int repeats = 7;
};

/// Sizes for the device, and others for a trial on the host.
struct Sizes {
  std::int64_t gaussians = 74088;
  int jobIterations = 0; // 0: the preset's
  std::int64_t large = 512;
  int largeEdge = 126; // Gaussians along each of its edges
  int plane = 512;
};

std::unique_ptr<cuda::Executor> executorOf(const Options& options);
/// Smooth waves between 20 and 180, if no volume is given.
Volume waves(std::int64_t nx, std::int64_t ny, std::int64_t nz);

struct JobRun {
  double toPaper = NAN, seconds = 0, fitSeconds = 0, psnr = 0, firstIteration = NAN;
  int iterations = 0;
  std::string device;
};

constexpr double kPaperPsnr = 32.47;
/// A whole reconstruction of every voxel of the volume, preset balanced.
JobRun job(const Volume& volume, const Sizes& sizes, const std::string& device, int threads);

/// A field in mid-fit, with its data.
struct Scene {
  GaussianField field;
  std::vector<Observation> observations;
};

Scene sceneOf(const Volume& volume, const Sizes& sizes, Blending blending);
FitRequest requestOf(const Scene& scene);

/// Seconds per iteration of a fit, in batches with one wait as in jobs. Learning rates of 0 keep the field.
double iterationSeconds(cuda::Fit& fit, const GaussianField& field, int repeats, int relocateEvery = 0);
double cpuIterationSeconds(const Scene& scene, int threads, int repeats);
/// Seconds per iteration over a large volume with Gaussians on an even grid; also returns their number.
double largeIteration(const Options& options, const Sizes& sizes, std::int64_t& gaussians);
/// An oblique plane through the middle of the volume, copied to host memory.
double planeMilliseconds(const Options& options, const Sizes& sizes, const Scene& scene,
                         const Volume& volume);

} // namespace innergs::bench
