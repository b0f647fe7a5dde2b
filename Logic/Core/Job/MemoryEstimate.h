#pragma once
#include "Core/Base/SystemMemory.h"
#include "Core/Job/ReconstructionJob.h"

#include <cstdint>
#include <span>
#include <string>

namespace innergs {

/// Bytes that a job needs beyond its input, including its second fit and its uncertainty.
std::int64_t estimateMemory(const ReconstructionInput& input, const Settings& settings);

/// The memory of fits that run one after the other: the reconstruction, then the one that measures its
/// quality.
struct MemoryNeed {
  std::int64_t bytes = 0; // peak, beyond the inputs
  std::string refusal;    // the sentence that refuses them; "" if they can start
};

/// available: bytes, 0 if unknown. The results of earlier fits stay in memory.
MemoryNeed memoryNeed(std::span<const ReconstructionInput> fits, const Settings& settings,
                      std::int64_t available = availableMemory());

/// The sentence that refuses a fit needing `needed` bytes; "" if they are available or if the available
/// memory is unknown (0).
std::string memoryRefusal(std::int64_t needed, std::int64_t available);

} // namespace innergs
