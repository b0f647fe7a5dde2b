#pragma once
#include <cstdint>
#include <span>

namespace innergs {

/// Takes noise of this standard deviation out of the differences of one slice from an estimate of it, rows of
/// `columns` pixels: a local Wiener filter in windows of 5 × 5 pixels (Lee 1980, Digital image enhancement
/// and noise filtering by use of local statistics, eq. 8). Non-finite differences stay as they are.
void wienerFilter(std::span<float> differences, std::int64_t columns, double noise);

} // namespace innergs
