#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// How often the truth lies within 1.645 standard deviations of the image, inside the mask. deviation: of the
/// image, on its grid. truthNoise: standard deviation of the truth's own noise, which is no error of the
/// image.
IntervalScore intervalScore(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask,
                            const Uncertainty& uncertainty, const Volume& deviation, double truthNoise);

} // namespace innergs
