#pragma once
#include <string>

namespace innergs::cli {

/// Functions that differ between operating systems.
bool errorStreamIsTerminal();
std::string utcTime(); // now, ISO 8601

} // namespace innergs::cli
