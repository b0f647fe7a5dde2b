#pragma once
#include "Core/Model/GaussianField.h"

#include <stop_token>

namespace innergs {

/// How much overlapping Gaussians of a normalised field disagree: for each Gaussian, the standard deviation
/// at its centre (weights w·p, scanner units) of the values c + g·d of all Gaussians that reach that point.
/// It is large at edges and where independently fitted members differ. A relative measure of uncertainty, not
/// an error bar. Throws Error(InvalidArgument) for other blendings, where a single Gaussian does not
/// represent a value; Error(Cancelled) when stopped.
std::vector<float> disagreement(const GaussianField& field, int threads = 0, std::stop_token stop = {});

} // namespace innergs
