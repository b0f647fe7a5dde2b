#pragma once
#include "Core/Features/FeatureModel.h"

namespace innergs {

/// Codes (unit vectors, FeatureModel::codes) of the classes of a support: vectors of classes that share
/// blocks are as nearly orthogonal as a choice among random ones makes them, for only they are told apart by
/// decoding.
std::vector<float> spreadCodes(const ClassSupport& support, int classes, int channels, std::uint64_t seed);

} // namespace innergs
