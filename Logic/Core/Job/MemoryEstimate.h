#pragma once
#include "Core/Base/SystemMemory.h"
#include "Core/Job/ReconstructionJob.h"

#include <cstdint>
#include <span>
#include <string>

namespace innergs {

/// What fits need that are made one after the other: the reconstruction, and then the one that judges its
/// quality.
struct MemoryNeed {
  std::int64_t bytes = 0; // at most at one time, beyond the inputs
  std::string refusal;    // the sentence with which they are refused; "" when they can start
};

/// available: bytes, 0 unknown. The results of the fits before are kept.
MemoryNeed memoryNeed(std::span<const ReconstructionInput> fits, const Settings& settings,
                      std::int64_t available = availableMemory());

/// The sentence with which one fit is refused that needs so many bytes; "" where that many are available, or
/// what is available is unknown (0).
std::string memoryRefusal(std::int64_t needed, std::int64_t available);

} // namespace innergs
