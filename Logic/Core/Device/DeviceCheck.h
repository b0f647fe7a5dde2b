#pragma once
#include <string>

namespace innergs {

class DevicePlugin;

/// A tiny fit of each blending and tiny renderings on a device beside the scalar CPU's (some 10 ms of
/// computing). Empty where they agree to 1e-3 of the largest value, each
/// parameter's gradient, moments and first step by themselves; else what does not, in a few words.
/// Whatever fails is thrown: memory, the driver.
std::string deviceDisagreement(DevicePlugin& plugin, int device);

} // namespace innergs
