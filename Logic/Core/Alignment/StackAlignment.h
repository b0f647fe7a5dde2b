#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// The position and gain of one of several scans relative to the others, at their common resolution.
struct StackAlignment {
  Affine3 toOthers;                     // rigid, LPS mm: applied to the scan; identity: not moved
  double displacement = 0;              // mm, root mean square over the body
  double angle = 0;                     // degrees
  double gain = 1;                      // factor for its values
  double correlation = 0;               // with the others, as used; NaN: too little overlap
  double psnrBefore = 0, psnrAfter = 0; // dB to the others, peak: their range; NaN: unknown
  bool fits = true;                     // false: neither moved nor scaled
};

/// Rigid registration and one gain for each scan after the first, which is fixed (the second, where all but
/// the first agree): Gauss-Newton on the squared difference of the equally blurred scans, from four times
/// their common resolution to once (Lucas and Kanade, 1981; Baker and Matthews, 2004), robust by Tukey's
/// weights (Beaton and Tukey, 1974); from several poses where the scan's own leads to nothing convincing.
/// Leaves scans in place that would move by less than still scans seem to. Uses only finite observed voxels,
/// and skips scans with slice poses. Bit-identical for any number of threads. Throws Error(Cancelled).
std::vector<StackAlignment> alignStacks(std::span<const Stack> stacks, ThreadPool& pool);

/// Moves and scales the scans accordingly.
void applyAlignment(std::span<const StackAlignment> alignment, std::span<Stack> stacks);

/// A sentence for the user: "Scan 2 was moved by 1.2 mm and turned by 0.4° to fit the others, …"; "" if
/// nothing was changed.
std::string alignmentSentence(const StackAlignment& alignment, const std::string& name);

} // namespace innergs
