#pragma once
#include "Evaluation/Protocols.h"

namespace innergs {

/// How often the truth lies within 1.645 standard deviations of the image, inside the mask. deviation: of the
/// image, on its lattice. measured: the truth is a measurement, with the scan's noise.
IntervalScore intervalScore(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask,
                            const Uncertainty& uncertainty, const Volume& deviation, bool measured);

} // namespace innergs
