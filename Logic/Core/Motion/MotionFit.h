#pragma once
#include "Core/Job/Progress.h"
#include "Core/Motion/CanonicalFit.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/FrameLoss.h"
#include "Core/Motion/RefinementState.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Kernels.h"

#include <functional>

namespace innergs {

/// All parameters of a fit of moving Gaussians. Lengths in voxels are of the finest spacing.
struct MotionPlan {
  CanonicalPlan canonical; // of the fit to the middle frame
  double nodeDistance = 6; // voxels between the grid's nodes

  int trackingSteps = 24;                          // Adam's, per frame
  double trackingShift = 0.2, trackingTurn = 0.02; // rates: voxels, Rodrigues vector
  double bending =
      1e-6; // weight of the grid's second differences (mm²), per squared normalised intensity and voxel

  int jointSteps = 2500;                       // Adam's, one frame each
  double jointShift = 0.05, jointTurn = 0.004; // rates of the grid's coefficients
  double jointBending = 1e-6;
  double canonicalRate = 0.3; // share of the first fit's rates
  double ownRate = 0.02;      // voxels
  double ownPenalty = 0.01;   // weight of the squared own displacements, mm²
  double finalRate = 0.05;    // rates decay exponentially to this share
};

/// SampleGrid values of one frame, tracked on its own.
struct TrackedFrame {
  std::vector<float> nodes; // six per node
  double mse = 0;           // normalised intensity²
};

/// The steps of a fit of moving Gaussians to a series: bit-identical at any number of threads. `report` is
/// called with the share of the current step that is done. Each step throws Error(Cancelled) when the pool is
/// stopped.
class MotionFit {
public:
  using Report = std::function<void(double share, double mse)>;

  /// device: where frames are rendered and gradients gathered; null: the CPU.
  MotionFit(const TimeSeries& series, const IntensityMap& map, MotionPlan plan, std::uint64_t seed,
            const KernelSet& kernels, ThreadPool& pool, DeviceChoice* device = nullptr);

  /// Fits the canonical Gaussians to the middle frame, with its edge voxels repeated in the margin.
  void fitCanonical(const Report& report);
  /// Tracks frame after frame outward from the middle one with a fixed canonical field, each from the pose
  /// extrapolated from those before.
  void track(const Report& report);
  /// The mean squared error with which splines of this many coefficients, through the poses of the other
  /// frames, predict every 4th frame, from each of four offsets in turn.
  double predictionError(int coefficients);
  /// The number of coefficients that predicts best; a few where there are too few frames to hold out any.
  int chooseCoefficients();
  /// The same for one frame, from the poses of its two neighbours, interpolated linearly, or (cubic) of up to
  /// two on either side.
  double predictionErrorBetween(std::int64_t frame, bool cubic);
  /// Fits a least-squares spline to all poses.
  void useSpline(int coefficients);
  /// Fits all parameters together, one frame per step, in a new random order each round. Call it after
  /// useSpline() or resume().
  void refine(const Report& report);
  /// Throws Error(FileFormat) unless field and state belong to a refinement with this plan.
  void resume(const DynamicField& field, const RefinementState& state);
  RefinementState state() const { return optimizer_.state(); }

  const std::vector<TrackedFrame>& tracked() const { return tracked_; }
  const DynamicField& field() const { return field_; }
  std::int64_t middle() const { return middle_; }

private:
  double errorOf(std::span<const float> nodes, std::int64_t frame);
  void startRefinement();

  const TimeSeries& series_;
  IntensityMap map_;
  MotionPlan plan_;
  std::uint64_t seed_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  DeviceChoice* device_;
  double voxel_; // finest spacing, mm
  std::int64_t middle_;
  DynamicField field_;
  FrameLoss loss_;
  std::vector<TrackedFrame> tracked_;
  RefinementOptimizer optimizer_;
};

} // namespace innergs
