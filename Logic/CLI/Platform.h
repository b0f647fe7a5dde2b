#pragma once
#include <cstdint>
#include <string>

namespace innergs::cli {

/// The few things that differ between operating systems.
bool errorStreamIsTerminal();
std::int64_t peakMemory(); // bytes resident at most so far; 0: unknown
std::string utcTime();     // now, ISO 8601

} // namespace innergs::cli
