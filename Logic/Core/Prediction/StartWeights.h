#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"

namespace innergs {

/// The parameters from which training starts: learned from the detail of other, open scans, seen through thin
/// or thick slices, whichever is nearer to the sampling (Docs/method.md; written by innergs_start_weights).
/// Outputs between those learned are interpolated. Empty if there are none for the shape's channels and
/// layers.
std::vector<float> startWeights(const ConvolutionNetwork::Shape& shape, const SliceSampling& sampling);

} // namespace innergs
