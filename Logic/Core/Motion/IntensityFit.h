#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Kernels.h"

#include <functional>

namespace innergs {

/// All parameters of a fit of changing intensities.
struct IntensityPlan {
  double voxelsPerGaussian = 1;    // of the frames' grid
  double width = 0.55;             // σ in distances between Gaussians
  double framesPerCoefficient = 3; // of the splines in time, unless held-out frames show faster changes
  int mostCoefficients = 64;       // likewise
  int coefficients = 0;            // fixed number of them; 0: chosen by the frames
  double neighbourhood = 1;        // voxels, σ: neighbourhood that shares the choice of smoothing in time
  int iterations = 8;              // conjugate-gradient iterations per coefficient
  double ridge = 1e-3;             // on the intensities, relative to a voxel's weight
  double cutoff = 2.5;             // Mahalanobis radius
};

/// A fit of a series without motion: keeps every voxel's mean over time, and Gaussians on an even grid carry
/// the difference from it as a spline in time. Both steps are linear: the voxels' time courses are smoothed
/// by a P-spline, with the smoothing chosen per voxel by holding out every 4th frame, and the intensities are
/// those whose field is closest to each coefficient's map (conjugate gradients). Slices count at the times at
/// which they were acquired.
/// Bit-identical for any number of threads. Throws Error(Cancelled) if the pool is stopped.
class IntensityFit {
public:
  using Report = std::function<void(double share)>;

  IntensityFit(const TimeSeries& series, const IntensityMap& map, IntensityPlan plan,
               const KernelSet& kernels, ThreadPool& pool);

  /// Chooses the coefficients of the splines, where the plan leaves them open, and the smoothing in time.
  void choose(const Report& report);
  /// How well the smoothed courses of the other frames predict a frame that is held out with every 4th one:
  /// mean squared error, normalised intensity². Not for the first and the last frame.
  double predictionError(std::int64_t frame) const;
  /// Solves for the Gaussians and their intensities.
  void solve(const Report& report);

  const DynamicField& field() const { return field_; }

private:
  void fillGaps();
  void keepMean();
  void chooseCoefficients();

  const TimeSeries& series_;
  IntensityMap map_;
  IntensityPlan plan_;
  SliceGroups slices_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  std::vector<std::vector<float>>
      course_; // [frame][voxel]: difference from the mean, normalised intensity, gaps filled
  std::vector<std::uint8_t> chosen_;             // [voxel]: of kSmoothings
  std::vector<std::vector<double>> frameErrors_; // [smoothing][frame], per voxel
  DynamicField field_;
};

} // namespace innergs
