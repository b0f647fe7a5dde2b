#pragma once
#include <cstdint>

namespace innergs {

/// Bytes of memory currently available to this process (0: unknown).
std::int64_t availableMemory();

} // namespace innergs
