#pragma once
#include <span>
#include <string>
#include <vector>

namespace innergs {

/// When slices were acquired (s), from the text of AcquisitionTime (0008,0032) of each or else of TriggerTime
/// (0018,1060); empty where one does not say, or all say the same.
std::vector<double> dicomSliceTimes(std::span<const std::string> acquired,
                                    std::span<const std::string> triggered);

} // namespace innergs
