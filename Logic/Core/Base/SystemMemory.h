#pragma once
#include <cstdint>

namespace innergs {

/// Bytes of memory currently available to this process (0: unknown).
std::int64_t availableMemory();
/// Most bytes that this process has had resident so far (0: unknown).
std::int64_t peakMemory();

} // namespace innergs
