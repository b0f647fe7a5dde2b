#pragma once
#include <cstdint>
#include <string>

/// Numbers as every message, report and panel writes them.
namespace innergs {

/// "850 kB", "64 MB", "1.6 GB", "120 GB": decimal units.
std::string bytesText(double bytes);
/// "1,045,528".
std::string countText(std::int64_t count);

} // namespace innergs
