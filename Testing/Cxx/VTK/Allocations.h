#pragma once
#include <cstddef>

/// Bytes that this thread has requested from operator new in large pieces (64 KiB and more) since the last
/// reset: what was copied, however often it was freed again.
namespace innergs::testing {

void resetLargeAllocations();
std::size_t largeAllocations();

} // namespace innergs::testing
