#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// How one scan of several lies to the others, found at the resolution that all share.
struct StackAlignment {
  Affine3 toOthers;                     // rigid, LPS mm: applied to the scan; identity: left where it is
  double displacement = 0;              // mm, root mean square over the body
  double angle = 0;                     // degrees
  double gain = 1;                      // its values are multiplied by it
  double correlation = 0;               // with the others as it is used; NaN: they share too little
  double psnrBefore = 0, psnrAfter = 0; // dB to the others, peak: their range; NaN: unknown
  bool fits = true;                     // false: neither moved nor scaled
};

/// Rigid registration and one gain for each scan after the first, which stays: Gauss-Newton on the squared
/// difference of the scans, blurred alike, from four times their common resolution to once (Lucas and Kanade,
/// 1981; Baker and Matthews, 2004), robust by Tukey's weights. Scans that move by less than what still scans
/// appear to are left alone. Looks at finite observed voxels only; scans with poses per slice are left out.
/// The bits do not depend on the number of threads. Throws Error(Cancelled).
std::vector<StackAlignment> alignStacks(std::span<const Stack> stacks, ThreadPool& pool);

/// Moves and scales the scans so.
void applyAlignment(std::span<const StackAlignment> alignment, std::span<Stack> stacks);

/// What was found, for the user: "Scan 2 was moved by 1.2 mm and turned by 0.4° to fit the others, …"; "":
/// nothing.
std::string alignmentSentence(const StackAlignment& alignment, const std::string& name);

} // namespace innergs
