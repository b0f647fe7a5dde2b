#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <stop_token>
#include <vector>

namespace innergs {

/// Body mask: above Otsu's threshold, largest component, holes filled slice by slice. Throws Error(Cancelled)
/// when stopped.
std::vector<std::uint8_t> bodyMask(const Volume& volume, const std::stop_token& stop = {});

} // namespace innergs
