#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <stop_token>
#include <vector>

namespace innergs {

/// Body mask: above foregroundThreshold(), the largest component, or all of them if it holds less than half
/// of their voxels (vessels, tracer uptake), holes filled slice by slice. Throws Error(Cancelled) when
/// stopped.
std::vector<std::uint8_t> bodyMask(const Volume& volume, const std::stop_token& stop = {});

} // namespace innergs
