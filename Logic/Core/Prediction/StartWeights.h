#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"

namespace innergs {

/// The parameters before the last layer from which training starts, for any number of phases: learned from
/// the in-plane detail of other, open scans (Docs/method.md; written by innergs_start_weights). Empty if
/// there are none for the shape's channels and layers.
std::vector<float> startWeights(const ConvolutionNetwork::Shape& shape);

} // namespace innergs
