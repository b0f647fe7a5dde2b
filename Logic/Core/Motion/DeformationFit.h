#pragma once
#include "Core/Motion/CanonicalFit.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/RefinementState.h"
#include "Core/Motion/TimeSeries.h"

#include <functional>

namespace innergs {

/// All parameters of a fit of a deformation network.
struct DeformationPlan {
  CanonicalPlan canonical;                          // of the fit to the middle frame
  std::vector<double> nodeDistances{12, 6};         // of the levels: finest voxels between nodes in space
  double framesPerNode = 2;                         // between nodes in time
  int times = 0;                                    // number of nodes in time instead; 0: not set
  int steps = 4000;                                 // Adam's, one frame each
  double growth = 0.5;                              // share of them until all frames take part
  double planeRate = 0.02, weightRate = 2e-3;       // of the network
  double canonicalRate = 0.3;                       // share of the first fit's rates
  double finalRate = 0.05;                          // rates decay exponentially to this share
  double smoothInTime = 1e-4, smoothInSpace = 1e-5; // weights (addPlaneSmoothness), per squared normalised
                                                    // intensity and voxel
};

/// The paper's dynamic scene: fits canonical Gaussians to the middle frame, then these and a deformation
/// network together, one frame per step. Frames join from the middle outward, so that what has moved far is
/// reached from its last known position. Bit-identical at any number of threads. Each step throws
/// Error(Cancelled) when the pool is stopped.
class DeformationFit {
public:
  using Report = std::function<void(double share, double mse)>;

  /// device: where frames are rendered and gradients gathered; the network stays on the CPU. Null: everything
  /// does.
  DeformationFit(const TimeSeries& series, const IntensityMap& map, DeformationPlan plan, std::uint64_t seed,
                 const KernelSet& kernels, ThreadPool& pool, DeviceChoice* device = nullptr);

  void fitCanonical(const Report& report);
  void refine(const Report& report);
  /// Call it instead of fitCanonical(). Throws Error(FileFormat) unless field and state belong to a
  /// refinement with this plan.
  void resume(const DynamicField& field, const RefinementState& state);
  RefinementState state() const { return optimizer_.state(); }

  const DynamicField& field() const { return field_; }

private:
  void startRefinement();

  const TimeSeries& series_;
  IntensityMap map_;
  DeformationPlan plan_;
  std::uint64_t seed_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  DeviceChoice* device_;
  double voxel_; // finest spacing, mm
  std::int64_t middle_;
  DynamicField field_;
  RefinementOptimizer optimizer_;
};

} // namespace innergs
