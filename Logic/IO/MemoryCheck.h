#pragma once
#include <string>

namespace innergs {

/// Throws Error(Memory) if `bytes` exceed the memory available to this process.
void checkMemoryFor(double bytes, const std::string& what);

} // namespace innergs
