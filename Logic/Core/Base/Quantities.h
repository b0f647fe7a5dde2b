#pragma once
#include <cstdint>
#include <string>

/// Formats numbers for messages, reports and panels.
namespace innergs {

/// "850 kB", "64 MB", "1.6 GB", "120 GB": decimal units.
std::string bytesText(double bytes);
/// "1,045,528".
std::string countText(std::int64_t count);
/// Without a unit, to three significant digits: "0.9", "4", "2.67", "1250".
std::string lengthText(double mm);

} // namespace innergs
