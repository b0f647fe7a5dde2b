#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Kernels.h"

#include <functional>

namespace innergs {

/// Everything that a fit of changing intensities does, as numbers.
struct IntensityPlan {
  double voxelsPerGaussian = 1;    // of the frames' lattice
  double width = 0.55;             // σ in distances between Gaussians
  double framesPerCoefficient = 3; // of the splines in time
  int mostCoefficients = 64;
  double neighbourhood = 1; // voxels, σ: over which the choice of the smoothing in time is shared
  int iterations = 8;       // of the conjugate gradients, per coefficient
  double ridge = 1e-3;      // on the intensities, relative to a voxel's weight
  double cutoff = 2.5;      // Mahalanobis radius
};

/// A series whose tissue stays where it is: every voxel's mean over time is kept, and Gaussians on an even
/// grid carry what differs from it as a spline in time. Two steps, both linear: the voxels' courses are
/// smoothed by a P-spline whose smoothing is chosen per voxel by withholding every 4th frame, and the
/// intensities are those whose field comes nearest to each coefficient's map (conjugate gradients).
/// Bit-identical at any number of threads. Throws Error(Cancelled) when the pool is stopped.
class IntensityFit {
public:
  using Report = std::function<void(double share)>;

  IntensityFit(const TimeSeries& series, const IntensityMap& map, IntensityPlan plan,
               const KernelSet& kernels, ThreadPool& pool);

  /// Chooses the smoothing in time.
  void choose(const Report& report);
  /// How well the smoothed courses of the other frames foresee one that is withheld with every 4th: mean
  /// squared error, normalised intensity². Not for the first and the last frame.
  double foresight(std::int64_t frame) const;
  /// Gaussians and their intensities.
  void solve(const Report& report);

  const DynamicField& field() const { return field_; }

private:
  void fillGaps();
  void keepMean();

  const TimeSeries& series_;
  IntensityMap map_;
  IntensityPlan plan_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  std::vector<std::vector<float>>
      course_; // [frame][voxel]: difference from the mean, normalised intensity, gaps filled
  std::vector<std::uint8_t> chosen_;             // [voxel]: of kSmoothings
  std::vector<std::vector<double>> frameErrors_; // [smoothing][frame], per voxel
  DynamicField field_;
};

} // namespace innergs
