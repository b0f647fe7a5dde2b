#pragma once
#include "Core/Prediction/ConvolutionNetwork.h"

namespace innergs {

/// Replaces drawn parameters by those from which training starts: learned from the detail of other, open
/// scans, seen through thin or thick slices, whichever is nearer to the sampling (Docs/method.md; written by
/// innergs_start_weights). Outputs between those learned are interpolated. The channels of a network wider
/// than those learned (16 or 32) keep drawn weights, but nothing uses them yet: the outputs are the same.
/// Does nothing unless the network has 4 layers.
void setStartWeights(ConvolutionNetwork& network, const SliceSampling& sampling);

} // namespace innergs
