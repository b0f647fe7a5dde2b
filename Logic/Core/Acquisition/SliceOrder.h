#pragma once
#include <span>
#include <string>

namespace innergs {

/// In how many passes slices were acquired, by their times (s): 1 if one after the other in either direction;
/// N of at least 2 if slices k, k + N, … of every k were acquired before or after those of any other k, for
/// the smallest such N that leaves no slice alone (2: odd and even slices); 0 if neither.
int interleavedPasses(std::span<const double> times);

/// "one after the other", "in 2 interleaved passes", "in another order"; empty without times.
std::string sliceOrderText(std::span<const double> times);

} // namespace innergs
