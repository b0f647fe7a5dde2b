#pragma once
#include "Core/Prediction/NetworkKernels.h"

#include <vector>

namespace innergs {

/// Approximates the nearest matrix with orthonormal columns (rows, if there are more columns than rows): five
/// Newton-Schulz steps bring all singular values near 1 (Jordan et al., Muon, 2024). values: [rows][columns].
void orthogonalise(std::vector<float>& values, std::int64_t rows, std::int64_t columns,
                   const NetworkKernels& kernels);

} // namespace innergs
