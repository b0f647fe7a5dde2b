#pragma once
#include <string>

namespace innergs {

class DevicePlugin;

/// A tiny fit of each blending and tiny renderings on a device beside the scalar CPU's (some 10 ms of
/// computing). Empty where they agree to 1e-3 of the largest value; else what does not, in a few words.
/// Throws Error(Memory) where the device has too little for even that.
std::string deviceDisagreement(DevicePlugin& plugin, int device);

} // namespace innergs
