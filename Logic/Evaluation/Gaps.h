#pragma once
#include "Core/Image/Stack.h"

#include <stop_token>

namespace innergs {

/// The stack's image with every unobserved or non-finite voxel replaced by the nearest observed one (in voxel
/// steps).
struct FilledStack {
  Volume image;
  std::vector<std::uint8_t> known; // per voxel; empty when nothing had to be filled
};

/// Throws Error(Cancelled) when stopped.
FilledStack fillGaps(const Stack& stack, const std::stop_token& stop = {});

} // namespace innergs
