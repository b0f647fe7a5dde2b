#pragma once
#include "Core/Image/Stack.h"

#include <stop_token>

namespace innergs {

/// A stack's image with every unobserved or non-finite voxel replaced by the nearest known one, measured in
/// voxel steps.
struct FilledImage {
  Volume image;
  std::vector<std::uint8_t> known; // 0 where a voxel was replaced; empty: all known
};
/// Throws Error(Cancelled) when stopped.
FilledImage filledImage(const Stack& stack, const std::stop_token& stop = {});

} // namespace innergs
