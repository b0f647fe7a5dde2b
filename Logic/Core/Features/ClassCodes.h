#pragma once
#include "Core/Features/FeatureModel.h"

namespace innergs {

/// Codes (unit vectors, FeatureModel::codes) of the classes of a support: classes that share blocks get the
/// most nearly orthogonal vectors among random draws, as only those must be told apart in decoding.
std::vector<float> spreadCodes(const ClassSupport& support, int classes, int channels, std::uint64_t seed);

} // namespace innergs
