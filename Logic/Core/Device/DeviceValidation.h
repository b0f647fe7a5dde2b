#pragma once
#include <stop_token>
#include <string>

namespace innergs {

class DevicePlugin;

/// The result of comparing a device with the CPU (DeviceCheck.h).
struct DeviceValidation {
  std::string refused; // one sentence; empty: it agrees with the CPU
  bool lasting = true; // false: it could not be compared now, e.g. for lack of memory
};

/// Starts the device and compares it with the CPU in a separate thread, once per process unless that fails.
/// Throws Error(Cancelled) if stopped first; the comparison continues for later callers.
DeviceValidation validateDevice(DevicePlugin& plugin, int device, const std::string& name,
                                const std::stop_token& stop);

/// What is known without touching the device: why it is permanently refused, or empty.
std::string knownRefusal(int device);

} // namespace innergs
