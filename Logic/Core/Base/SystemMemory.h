#pragma once
#include <cstdint>

namespace innergs {

/// Bytes of memory available to this process now (0: unknown).
std::int64_t availableMemory();

} // namespace innergs
