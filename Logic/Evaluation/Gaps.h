#pragma once
#include "Core/Stack.h"

namespace innergs {

/// The stack's image with every unobserved or non-finite voxel replaced by the nearest observed one (in voxel
/// steps).
struct FilledStack {
  Volume image;
  std::vector<std::uint8_t> known; // per voxel; empty when nothing had to be filled
};

FilledStack fillGaps(const Stack& stack);

} // namespace innergs
