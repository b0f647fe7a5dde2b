#pragma once
#include "Core/Prediction/CandidateWeights.h"

namespace innergs {

/// How the interpolations of one scan are weighed, by what the scan itself shows: its slices,
/// withheld from each other, and its in-plane images, blurred and degraded as its slices are.
struct CandidateChoice {
  std::array<double, kCandidates> share{0, 1, 0, 0}; // convex
  double krigingBlur = 0;                            // mm: σ of what the kriging expects
  bool backProject = true; // thick slices: demanding the scan's own values of the result pays
  bool judged = false;     // false: too little to judge by, the shares are a guess
  double blur = 0;         // σ of the in-plane images' blur that fits the scan best, in in-plane samples
  std::array<double, kCandidates> pairError{}; // RMS on the simulated pairs, image units; judged only
  double error = 0;                            // the same of the chosen mixture
  /// Error at the slices' distance over that at twice it, of linear interpolation and of the mixture, on the
  /// simulated pairs; 0: not judged.
  double linearFall = 0, fall = 0;
  std::array<double, kCandidates> withheldError{}; // RMS on slices withheld from each other, at twice the
                                                   // distance; 0: too few slices
};

/// complete: see completeSlices(). Withheld and non-finite voxels are never looked at beyond it. Throws
/// Error(Cancelled).
CandidateChoice chooseCandidates(const Stack& stack, std::span<const float> complete, ThreadPool& pool);

/// Of three or four guesses' errors, [row][column].
template <std::size_t N>
using Covariance = std::array<std::array<double, N>, N>;

/// Mean squared error of the guesses mixed so.
template <std::size_t N>
double meanSquare(const Covariance<N>& errors, const std::array<double, N>& share) {
  double sum = 0;
  for (std::size_t a = 0; a < N; ++a)
    for (std::size_t b = 0; b < N; ++b)
      sum += share[a] * share[b] * errors[a][b];
  return sum;
}

/// The shares, at least 0 and 1 in sum, whose excess over the best possible is the least in the worst case.
template <std::size_t N>
std::array<double, N> convexShares(std::span<const Covariance<N>> cases);

} // namespace innergs
