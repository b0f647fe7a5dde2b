#pragma once
#include "Core/Alignment/BiasField.h"
#include "Core/Alignment/StackAlignment.h"

#include <limits>

namespace innergs {

/// The smooth shading of several scans of one body, such as by MR coils.
struct BiasCorrection {
  /// What one scan's values are divided by, where the scan lies once aligned, and its range in the body
  /// relative to the other scans.
  struct Scan {
    BiasField field;
    double lowest = 1, highest = 1;
  };
  std::vector<Scan> scans;                    // one per stack; empty: nothing was corrected
  double sharedLowest = 1, sharedHighest = 1; // range in the body of what all scans share; 1: none found
  double sharedDeviation = 0; // standard deviation, of the values, of what all scans may still share
  double psnrBefore = std::numeric_limits<double>::quiet_NaN(); // dB between the scans, each times one gain;
  double psnrAfter = psnrBefore;                                // NaN: unknown
};

/// Finds a polynomial of fourth degree for the logarithm of each scan's brightness, from the robust
/// differences to the others at their common resolution, and one of second degree that all scans share, from
/// their histogram (HistogramSharpening.h). `alignment` (empty: scans stay) is refined on the
/// corrected scans. Corrects nothing if that would improve their agreement by less than 0.5 dB (unless
/// `always`), and never scans with values below zero or that do not correlate with the others.
/// Bit-identical for any number of threads. Throws Error(Cancelled).
BiasCorrection findBias(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment, bool always,
                        ThreadPool& pool);

/// What findBias() would correct where it is clear (6 dB), without what all scans share: what must not be
/// taken for motion if it stays. `alignment` is refined likewise.
BiasCorrection findShading(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment,
                           ThreadPool& pool);

/// Divides one aligned stack's values by its field; with `kept`, multiplies them by that field, so that all
/// stacks are shaded alike.
void applyBias(const BiasCorrection::Scan& scan, Stack& stack, ThreadPool& pool,
               const BiasCorrection::Scan* kept = nullptr);

/// "Scan 2 is shaded by 0.71 to 1.38 against the others: this was corrected."; "" if it was not.
std::string biasSentence(const BiasCorrection::Scan& scan, const std::string& name);
/// What was done to all scans together; "" for nothing. kept: the scan whose shading all were given, or "".
std::string biasSentence(const BiasCorrection& correction, const std::string& kept = {});
/// That scans look shaded and could be corrected; "" if they do not.
std::string shadingSentence(const BiasCorrection& found);

} // namespace innergs
