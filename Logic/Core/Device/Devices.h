#pragma once
#include "Core/Settings/Settings.h"

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

namespace innergs {

class DevicePlugin;
class FieldDevice;
class FitDevice;
struct DeviceList;
struct FitRequest;

/// Where a fit runs, for people: in progress, reports and the result.
struct DeviceUse {
  std::string asked = "auto"; // as in Settings
  std::string id = "cpu";     // or "cuda:N"
  std::string name = "CPU";   // as its maker calls it
  std::string reason;         // one or two sentences: why here, and what went wrong elsewhere
};

/// The devices besides the CPU, or one sentence why there is none: no plugin (beside the program or in a
/// folder of INNERGS_PLUGIN_PATH), one that cannot be loaded or belongs to another build, no driver, no
/// device. Asked anew at every call; a plugin is loaded once. Every device is started, and compared with the
/// CPU once (DeviceValidation.h). Never throws.
DeviceList otherDevices();

/// One of otherDevices(), or the CPU.
class DeviceChoice {
public:
  DeviceUse use;

  /// What `asked` ("auto", "cpu", "cuda", "cuda:N") leads to before any device is started. "auto": the device
  /// with the most memory, or the CPU when there is none or when the settings name something that only
  /// the CPU has (instruction set, candidate selection). A device that is known to compute otherwise
  /// than the CPU is never taken. Throws Error(InvalidArgument) for "cuda" where it cannot be had.
  DeviceChoice(const std::string& asked, const std::string& instructionSet = {},
               Selection selection = Selection::Exact);

  bool onCpu() const { return !plugin_; }
  /// "auto" stays on the CPU with a fit so small that a device would not be worth its start.
  void considerSize(const FitRequest& request);
  void considerSize(double samples, int iterations);
  /// The fit on the device, started and compared with the CPU (DeviceValidation.h); null on the CPU. When
  /// that fails, the fit does not fit into the device's memory or cannot be made, the choice becomes the next
  /// device or the CPU and the reason says why. Throws Error(InvalidArgument) where "cuda" leads to devices
  /// only that compute otherwise, Error(Cancelled) when stopped.
  std::unique_ptr<FitDevice> makeFit(const FitRequest& request);
  /// The field on the device, likewise, to be looked at; null on the CPU and where it cannot be made.
  std::shared_ptr<FieldDevice> makeField(const GaussianField& field, const std::stop_token& stop = {});
  /// The CPU from now on.
  void leave(const std::string& why);
  /// FitDevice::remark() into the reason. False when it is there already, or empty.
  bool note(const std::string& remark);

private:
  struct Candidate {
    int index;
    std::string name;
  };

  std::string label() const;
  void pass(const std::string& why, bool disagrees);
  void validate(const std::stop_token& stop);

  bool insists_ = false, onlyDisagree_ = true;
  std::vector<Candidate> candidates_; // still to be tried
  std::string passed_;                // what spoke against the others
  DevicePlugin* plugin_ = nullptr;    // belongs to its library
  int index_ = 0;
};

/// The field where `asked` leads for so many samples to render: "auto" takes a device from eight million on.
/// Null on the CPU; a device that was asked for and cannot hold the field: null as well, and `problem` says
/// so (one sentence). Throws as DeviceChoice does.
std::shared_ptr<FieldDevice> renderingDevice(const std::string& asked, const GaussianField& field,
                                             std::int64_t samples, const std::string& instructionSet = {},
                                             Selection selection = Selection::Exact,
                                             std::string* problem = nullptr);

} // namespace innergs
