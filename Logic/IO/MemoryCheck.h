#pragma once
#include <string>

namespace innergs {

/// Throws Error(Memory) when `bytes` are more than this process can have now.
void checkMemoryFor(double bytes, const std::string& what);

} // namespace innergs
