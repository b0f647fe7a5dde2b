#pragma once
#include <string>

namespace innergs {

/// The device named by a setting: "auto", "cpu", "cuda" (any) or "cuda:N".
struct DeviceRequest {
  enum class Kind { Auto, Cpu, Cuda } kind = Kind::Auto;
  int index = -1; // -1: any
};

/// Throws Error(InvalidArgument) for any other name.
DeviceRequest parseDeviceRequest(const std::string& name);

} // namespace innergs
