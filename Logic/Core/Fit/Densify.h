#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Reshape.h"
#include "Core/Settings/Settings.h"

namespace innergs {

/// Pruning and densification as the paper's Algorithm 1, every few iterations between two of them. Per
/// Gaussian:
/// - α, its opacity: alpha blending's own; normalised: its weight w (new ones have 1); additive: |w·c|, its
///   amplitude as a share of the intensity range;
/// - ‖∇μ‖, its positional gradient: by how much the loss, summed over the samples, would fall if the Gaussian
/// moved by one
///   voxel, divided by how often a voxel is seen (all axes: 3). Its unit is the loss of one sample, so it
///   depends neither on the size of the volume nor on that of its voxels in mm;
/// - its size: largest σ in voxels, and ‖Σ‖_F = √(Σ σ⁴) in voxels².
struct DensifyPlan {
  int every = 0;      // iterations; 0 = never
  double until = 0.5; // share of the iterations
  DensifyThresholds thresholds;
  std::int64_t limit = 0;   // Gaussians, at most
  double voxel = 1;         // mm
  double coverage = 1;      // samples per voxel
  double minLogScale = -10; // of the halves of a split
};

/// Sum of every Gaussian's positional gradient over the iterations since the last densification; nothing
/// depends on the number of threads.
class GradientAccumulator {
public:
  /// gradient: 16 floats per Gaussian, of the loss summed over the samples.
  void add(std::span<const float> gradient, const DensifyPlan& plan, ThreadPool& pool);
  void clear();

  std::vector<float> sum; // one per Gaussian; empty before the first iteration
  int iterations = 0;
};

struct DensifyCounts {
  std::int64_t pruned = 0, split = 0, cloned = 0;

  DensifyCounts& operator+=(const DensifyCounts& other) {
    pruned += other.pruned;
    split += other.split;
    cloned += other.cloned;
    return *this;
  }
};

/// The plan's thresholds in the units of the field; iterations: that the gradients were summed over.
reshape::Rules densifyRules(const DensifyPlan& plan, Blending blending, int iterations);

/// Prunes Gaussians whose α is below τ_α or whose largest σ is above the limit; of the others, those
/// whose gradient is above τ_p (mean over the iterations) become two, the largest first, while there is room:
/// split along their longest axis when ‖Σ‖_F is above τ_s, else cloned (two that together blend as the one
/// did at its centre, the copy shifted half its smallest σ the way the gradient points). New ones start with
/// Adam moments of 0. A field that changed is sorted along a Morton curve; `accumulator` starts anew. At
/// least one Gaussian is left.
DensifyCounts densifyGaussians(GaussianField& field, Adam& adam, GradientAccumulator& accumulator,
                               const DensifyPlan& plan);

} // namespace innergs
