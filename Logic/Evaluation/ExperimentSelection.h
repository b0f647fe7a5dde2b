#pragma once
#include "Core/Model/GaussianField.h"
#include "Core/Settings/Selection.h"
#include "Evaluation/ExperimentTable.h"

#include <span>
#include <stop_token>

namespace innergs {

/// The paper's simulation of candidate selection. Lengths in voxels; axial slices of a cube.
struct SelectionSimulation {
  int size = 20;             // voxels along each edge
  int gaussians = 50;        // per cloud
  double low = 5, high = 15; // the means are uniform in [low, high]³
  double threshold = 0.01;   // p (peak 1) from which a Gaussian contributes to a pixel
  /// σ along the three axes, randomly rotated. The paper does not say how it draws covariances: the first
  /// value gives its mean area for Method 1, (6σ)² = 209.80; the other two come closest to its other figures.
  Vec3 sigma{2.41408, 1.352, 0.398};
  int clouds = 200; // number averaged over
  std::uint64_t seed = 1;
  int repetitions = 15; // of the timing; the median counts
};

/// (Gaussian, pixel, slice) triples of one or several clouds, counted over every slice of the cube.
struct SelectionCounts {
  std::int64_t contributing = 0;   // p ≥ threshold
  std::int64_t candidates = 0;     // pixels that the selection evaluates
  std::int64_t falsePositives = 0; // candidates that do not contribute
  std::int64_t falseNegatives = 0; // contributing, but not evaluated
  std::int64_t slices = 0;         // (Gaussian, slice) pairs that the selection reaches
  double area = 0;                 // total area of the candidate boxes, pixels² (not clipped to the cube)

  SelectionCounts& operator+=(const SelectionCounts& other);
};

/// A random cloud: normalised blending, weights 1, cut-off where p = threshold.
GaussianField simulatedCloud(const SelectionSimulation& simulation, std::uint64_t seed);

/// Candidates come from the engine's own traversal; contributions are evaluated in double precision.
SelectionCounts countCandidates(const GaussianField& cloud, const SelectionSimulation& simulation,
                                Selection selection);

struct SelectionScore {
  Selection selection = Selection::Exact;
  SelectionCounts counts;
  // Per cloud, median of the repetitions; one thread, all slices.
  double seconds = 0;       // SIMD kernels, which evaluate full vectors and mask them
  double scalarSeconds = 0; // scalar kernels, which evaluate only the candidates
};

/// Runs Method 1, Method 2 and Exact on the same clouds, timed by interleaved repetitions. Throws
/// Error(InvalidArgument) for a simulation without Gaussians, voxels or clouds, with a threshold outside (0,
/// 1) or a limit that is not finite; Error(Cancelled).
/// instructionSet: of the SIMD kernels; "": the best.
std::vector<SelectionScore> simulateSelections(const SelectionSimulation& simulation,
                                               const std::string& instructionSet = "",
                                               std::stop_token stop = {});

ExperimentTable selectionTable(const SelectionSimulation& simulation, std::span<const SelectionScore> scores);

} // namespace innergs
