#pragma once
#include <functional>
#include <span>
#include <vector>

namespace innergs {

/// The smooth shading under which logarithms of values have the sharpest histogram: the non-parametric
/// iterative deconvolution of Sled, Zijdenbos and Evans (N3, 1998), with a linear model in place of splines.
/// terms: [logs.size()][count], without the constant, over which the shading is linear.
/// Returns the coefficients [count]; none for fewer than a thousand values.
std::vector<double> sharpestShading(std::span<const double> logs, std::span<const double> terms, int count,
                                    const std::function<void()>& throwIfStopped);

} // namespace innergs
