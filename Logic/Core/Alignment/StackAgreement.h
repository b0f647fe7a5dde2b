#pragma once
#include "Core/Alignment/StackAlignment.h"

#include <limits>

namespace innergs {

/// How well one of several scans agrees with the others.
struct StackAgreement {
  double correlation = std::numeric_limits<double>::quiet_NaN(); // with them; NaN: too little in common
  double psnr = correlation;       // dB between them, peak: their range; NaN: unknown
  double ratio = 1;                // of their brightness to this scan's
  bool fits = true;                // false: it does not show what most of the others show
  double fittedPsnr = correlation; // dB of its slices, which the result was fitted to; NaN: not measured
};

/// Compares scans as they lie, at their common resolution and where they show the body: each with the mean of
/// the others that it goes with, which are the most scans that correlate with each other. Skips scans with
/// slice poses. Changes nothing. Throws Error(Cancelled).
std::vector<StackAgreement> compareStacks(std::span<const Stack> stacks, ThreadPool& pool);

/// The same from what an alignment has measured.
std::vector<StackAgreement> agreementsOf(std::span<const StackAlignment> alignment);

/// For the user, on all scans: "The scans agree: PSNR between them 31.2 dB, …", and what the result shows of
/// them where that was measured; "" for less than two.
std::string agreementSentence(std::span<const StackAgreement> agreement);

/// One on a scan that does not fit the others; "" if it fits. slicesMoved: only its slices were moved;
/// otherwise nothing of it was.
std::string misfitSentence(const StackAgreement& agreement, const std::string& name,
                           bool slicesMoved = false);

} // namespace innergs
