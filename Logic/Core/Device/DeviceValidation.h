#pragma once
#include <stop_token>
#include <string>

namespace innergs {

class DevicePlugin;

/// What the comparison of a device with the CPU (DeviceCheck.h) led to.
struct DeviceValidation {
  std::string refused; // one sentence; empty: it computes as the CPU does
  bool lasting = true; // false: it could not be compared now, for want of memory and the like
};

/// Starts the device and compares it, in a thread of its own, once per process unless that fails. Throws
/// Error(Cancelled) when stopped before the end; the comparison then goes on for who asks next.
DeviceValidation validateDevice(DevicePlugin& plugin, int device, const std::string& name,
                                const std::stop_token& stop);

/// What is known without touching the device: why it is refused for good, or empty.
std::string knownRefusal(int device);

} // namespace innergs
