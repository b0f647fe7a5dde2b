#pragma once
#include "Core/Model/GaussianField.h"

#include <stop_token>

namespace innergs {

/// How much overlapping Gaussians of a normalised field contradict each other: per Gaussian, at its centre,
/// the standard deviation (weights w·p) of the values c + g·d that all Gaussians reaching that point have
/// there, in scanner units. It is large at edges and where independently fitted members differ. A relative
/// measure of uncertainty, no error bar. Throws Error(InvalidArgument) for other blendings, whose Gaussians
/// do not each stand for a value; Error(Cancelled).
std::vector<float> disagreement(const GaussianField& field, int threads = 0, std::stop_token stop = {});

} // namespace innergs
