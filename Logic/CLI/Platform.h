#pragma once
#include <cstdint>
#include <string>

namespace innergs::cli {

/// Functions that differ between operating systems.
bool errorStreamIsTerminal();
std::int64_t peakMemory(); // peak resident bytes; 0: unknown
std::string utcTime();     // now, ISO 8601

} // namespace innergs::cli
