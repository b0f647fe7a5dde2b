#pragma once
#include "Core/Settings/Settings.h"

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

namespace innergs {

class DevicePlugin;
class FeatureDevice;
class FieldDevice;
class FitDevice;
struct DeviceList;
struct FeatureProblem;
struct FitRequest;

/// Where a fit runs, for progress, reports and results.
struct DeviceUse {
  std::string asked = "auto"; // as in Settings
  std::string id = "cpu";     // or "cuda:N"
  std::string name = "CPU";   // the manufacturer's name
  std::string reason;         // one or two sentences: why here, and what went wrong elsewhere
};

/// The devices other than the CPU, or one sentence on why there is none: no plugin (beside the program or in
/// a folder of INNERGS_PLUGIN_PATH), one that cannot be loaded or belongs to another build, no driver, no
/// device. Queried at every call; a plugin is loaded once. Starts every device and compares it with the CPU
/// once (DeviceValidation.h). Never throws.
DeviceList otherDevices();

/// One of otherDevices(), or the CPU.
class DeviceChoice {
public:
  DeviceUse use;

  /// Resolves `asked` ("auto", "cpu", "cuda", "cuda:N") without starting a device. "auto": the device with
  /// the most memory, or the CPU if there is none or if the settings need something that only the CPU has
  /// (instruction set, candidate selection). Never takes a device known to disagree with the CPU. Throws
  /// Error(InvalidArgument) if "cuda" is asked for but not available.
  DeviceChoice(const std::string& asked, const std::string& instructionSet = {},
               Selection selection = Selection::Exact);

  bool onCpu() const { return !plugin_; }
  /// Keeps "auto" on the CPU for a fit too small to be worth starting a device.
  void considerSize(const FitRequest& request);
  void considerSize(double samples, int iterations);
  /// The fit on the device, started and compared with the CPU (DeviceValidation.h); null on the CPU. If that
  /// fails, or the fit does not fit into the device's memory or cannot be made, moves on to the next device
  /// or the CPU and says why in the reason. Throws Error(InvalidArgument) if "cuda" finds only devices that
  /// disagree with the CPU, Error(Cancelled) when stopped.
  std::unique_ptr<FitDevice> makeFit(const FitRequest& request);
  /// Likewise the field on the device, for rendering; null on the CPU and if it cannot be made.
  std::shared_ptr<FieldDevice> makeField(const GaussianField& field, const std::stop_token& stop = {});
  /// Likewise what features are learned from; null on the CPU. If the device cannot hold it, moves on to the
  /// CPU and says why in the reason.
  std::unique_ptr<FeatureDevice> makeFeatures(const FeatureProblem& problem,
                                              const std::stop_token& stop = {});
  /// Switches to the CPU for good.
  void leave(const std::string& why);
  /// The same where the device failed. how: "after iteration 3, and the fit continued".
  void failed(const std::string& how, const std::string& why);
  /// Adds FitDevice::remark() to the reason. False if it is empty or already there.
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
  std::vector<Candidate> candidates_; // not tried yet
  std::string passed_;                // why the others were ruled out
  std::string memory_;                // what the last fit needs: part of the reason
  DevicePlugin* plugin_ = nullptr;    // owned by its library
  int index_ = 0;
};

/// The field on the device that `asked` resolves to, for rendering that many samples: "auto" takes a device
/// from eight million on. Null on the CPU; also null, with one sentence in `problem`, if a requested device
/// cannot hold the field. Throws like DeviceChoice.
std::shared_ptr<FieldDevice> renderingDevice(const std::string& asked, const GaussianField& field,
                                             std::int64_t samples, const std::string& instructionSet = {},
                                             Selection selection = Selection::Exact,
                                             std::string* problem = nullptr);

} // namespace innergs
