#pragma once
#include "Core/Prediction/CandidateWeights.h"

namespace innergs {

/// The weights of the interpolations for one scan, derived from the scan itself: from its slices held out
/// from each other, and from its in-plane images, blurred and degraded like its slices.
struct CandidateChoice {
  std::array<double, kCandidates> share{0.2, 0, 0.8, 0}; // convex
  double krigingBlur = 0;                                // mm: σ that the kriging assumes
  bool backProject = true; // thick slices: enforcing the scan's own values improves the result
  bool judged = false;     // false: too little to judge by, the shares are a guess
  double blur = 0;         // σ of the least in-plane blur that fits the scan about best, in in-plane samples
  std::array<double, kCandidates> pairError{}; // RMS on the simulated pairs, image units; only if judged
  double error = 0;                            // likewise for the chosen mixture
  /// Error at the slice distance relative to that at twice the distance, of linear interpolation and of the
  /// mixture, on the simulated pairs; 0: not judged.
  double linearFall = 0, fall = 0;
  std::array<double, kCandidates> heldOutError{}; // RMS on slices held out from each other, at twice the
                                                  // distance; 0: too few slices
  std::vector<std::uint8_t> inside;               // 1 for the scan's voxels that were judged by
};

/// complete: see completeSlices(). Uses held-out and non-finite voxels only through it. Throws
/// Error(Cancelled).
CandidateChoice chooseCandidates(const Stack& stack, std::span<const float> complete, ThreadPool& pool);

} // namespace innergs
