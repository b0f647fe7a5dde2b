#pragma once
#include "Core/Prediction/ProfileEstimate.h"

#include <span>
#include <vector>

namespace innergs {

/// How thick the slices of a job's scans look. Only said: fits take the stated thickness, as an estimate that
/// is too large costs more than one that is right gains.
struct ShownProfiles {
  std::vector<ProfileEstimate> scans; // of the middle of each
  std::string sentence;               // for the user; empty: nothing can be said
};

/// Throws Error(Cancelled) if the pool is stopped.
ShownProfiles shownProfiles(std::span<const Stack> stacks, ThreadPool& pool);

} // namespace innergs
