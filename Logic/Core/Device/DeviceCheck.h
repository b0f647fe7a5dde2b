#pragma once
#include <string>

namespace innergs {

class DevicePlugin;

/// Runs a tiny fit of each blending and tiny renderings on a device and on the scalar CPU (some 10 ms of
/// computing). Empty if they agree to 1e-3 of the largest value, with the gradient, moments and first step
/// compared per parameter; otherwise a few words on what differs.
/// Rethrows every failure: memory, the driver.
std::string deviceDisagreement(DevicePlugin& plugin, int device);

} // namespace innergs
