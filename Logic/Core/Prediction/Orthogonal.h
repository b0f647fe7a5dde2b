#pragma once
#include "Core/Prediction/MatrixKernels.h"

#include <vector>

namespace innergs {

/// The nearest matrix with orthonormal columns (or, of more columns than rows, rows), roughly: all singular
/// values brought near 1 by five Newton-Schulz steps (Jordan et al., Muon, 2024). values: [rows][columns].
void orthogonalise(std::vector<float>& values, std::int64_t rows, std::int64_t columns,
                   const MatrixKernels& kernels);

} // namespace innergs
