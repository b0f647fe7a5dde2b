#pragma once
#include <cstdint>
#include <string>

namespace innergs {

/// For sentences, with a decimal point in every locale: six significant digits ("0.9", "1e-06").
std::string numberText(double value);
/// "1,045,528".
std::string countText(std::int64_t count);

} // namespace innergs
