#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Reshape.h"
#include "Core/Settings/Settings.h"

namespace innergs {

/// Pruning and densification as in the paper's Algorithm 1 (after Kerbl et al. 2023) every few iterations, by
/// - α, its opacity: alpha blending's own; normalised: its weight w (new ones have 1); additive: |w·c|, its
///   amplitude as a share of the intensity range;
/// - ‖∇μ‖, its positional gradient: how much the loss, summed over the samples, would fall if the Gaussian
///   moved by one voxel, divided by how often a voxel is seen (all axes: 3). Its unit is the loss of one
///   sample, so it depends neither on the size of the volume nor on that of its voxels in mm;
/// - its size: the largest σ in voxels, and ‖Σ‖_F = √(Σ σ⁴) in voxels².
struct DensifyPlan {
  int every = 0;      // iterations; 0 = never
  double until = 0.5; // share of the iterations during which it runs
  DensifyThresholds thresholds;
  std::int64_t limit = 0;   // maximum number of Gaussians
  double voxel = 1;         // mm
  double coverage = 1;      // samples per voxel
  double minLogScale = -10; // for the halves of a split
};

/// Sum of each Gaussian's positional gradient over the iterations since the last densification; independent
/// of the number of threads.
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

/// The plan's thresholds in the units of the field. iterations: how many the gradients were summed over.
reshape::Rules densifyRules(const DensifyPlan& plan, Blending blending, int iterations);

/// Prunes Gaussians whose α is below τ_α or whose largest σ is above the limit. Of the rest, those whose
/// gradient (mean over the iterations) is above τ_p become two, strongest first, while there is room: split
/// along the longest axis if ‖Σ‖_F is above τ_s, else cloned (together the two blend like the original at its
/// centre, with the copy shifted by half its smallest σ down the gradient). New Gaussians start with zero
/// Adam moments. A changed field is sorted along a Morton curve and `accumulator` is cleared. Always keeps at
/// least one Gaussian.
DensifyCounts densifyGaussians(GaussianField& field, Adam& adam, GradientAccumulator& accumulator,
                               const DensifyPlan& plan);

} // namespace innergs
