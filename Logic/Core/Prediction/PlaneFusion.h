#pragma once
#include "Core/Base/Parallel.h"

#include <array>
#include <cstdint>
#include <vector>

namespace innergs {

/// Combines two predictions of the same samples, made in the planes along I and in those along J. A plane
/// shows how structures lean only as far as they vary along it, so each prediction weighs as much as the root
/// mean square gradient along its own axis, over 3×3×3 samples of their mean.
std::vector<float> fusedPlanes(const std::array<std::vector<float>, 2>& predicted,
                               const std::array<std::int64_t, 3>& size, ThreadPool& pool);

} // namespace innergs
