#pragma once
#include "Core/Image/Stack.h"
#include "Core/Settings/Settings.h"

#include <span>
#include <string>
#include <vector>

namespace innergs::cli {

/// Sentences on how the scans were acquired, as far as it matters to a fit: a thickness of slices that is
/// assumed, and interleaved passes, which `packets` could move as wholes.
std::vector<std::string> scanRemarks(std::span<const Stack> stacks, const Settings& settings);

} // namespace innergs::cli
