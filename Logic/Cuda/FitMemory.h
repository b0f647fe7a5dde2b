#pragma once
#include "Core/Fit/FitDevice.h"

#include <cstdint>

namespace innergs::cuda {

constexpr std::int64_t kSlabPoints = std::int64_t{1} << 27; // maximum per slab

/// Bytes that a fit needs with the largest slabs and with the smallest (one slice).
struct FitMemory {
  std::int64_t most, least;
};
FitMemory fitMemory(const FitRequest& request);

} // namespace innergs::cuda
