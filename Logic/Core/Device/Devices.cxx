#include "Core/Device/Devices.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/PathText.h"
#include "Core/Base/Quantities.h"
#include "Core/Base/SharedLibrary.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/DeviceValidation.h"
#include "Core/Settings/DeviceRequest.h"

#include <algorithm>
#include <cstdlib>

namespace innergs {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBackend = "innergs_cuda";

/// System messages may end with or without punctuation.
std::string sentence(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.'))
    text.pop_back();
  return text + ".";
}

/// INNERGS_PLUGIN_PATH first, then the folders of builds and installations.
std::vector<fs::path> pluginFolders() {
  std::vector<fs::path> folders;
  if (const char* path = std::getenv("INNERGS_PLUGIN_PATH")) {
#ifdef _WIN32
    const char separator = ';';
#else
    const char separator = ':';
#endif
    const std::string text = path;
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find(separator, begin), text.size());
      if (end > begin) folders.emplace_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  for (const fs::path& beside : programFolders())
    for (const char* where : {"", "innergs", INNERGS_PLUGIN_FOLDER, "../lib/innergs", "../lib"})
      folders.push_back(beside / where);
  return folders;
}

struct Backend {
  DevicePlugin* plugin = nullptr;
  std::string problem;
};

Backend load(const fs::path& file) {
  const std::string name = "The CUDA backend " + utf8(file);
  Backend backend;
  std::string why;
  void* library = openSharedLibrary(file, why);
  if (!library) return {nullptr, sentence(name + " cannot be loaded: " + why)};
  const auto stampOf = reinterpret_cast<PluginStampFunction>(sharedSymbol(library, kPluginStampSymbol));
  const auto pluginOf = reinterpret_cast<PluginFunction>(sharedSymbol(library, kPluginSymbol));
  if (!stampOf || !pluginOf) return {nullptr, name + " is not a plugin of InnerGS: remove or replace it."};
  const PluginStamp* stamp = stampOf();
  const std::string build = INNERGS_PLUGIN_VERSION " " INNERGS_PLUGIN_COMPILER;
  if (!stamp || stamp->abi != kPluginAbi || stamp->layout != pluginLayout() || stamp->build != build)
    return {nullptr, name +
                         " belongs to another build of InnerGS: install the one that came with this "
                         "program (" +
                         build + ")."};
  try {
    backend.plugin = pluginOf();
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (!backend.plugin) backend.problem = sentence(name + " did not start: " + why);
  return backend;
}

/// The plugin, found and loaded at the first call; the first file with its name is used.
const Backend& backend() {
  static const Backend found = [] {
    for (const fs::path& folder : pluginFolders()) {
      std::error_code none;
      const fs::path file = fs::weakly_canonical(folder / sharedLibraryName(kBackend), none);
      if (!none && fs::is_regular_file(file, none)) return load(file);
    }
    return Backend{nullptr, "The CUDA backend is not installed."};
  }();
  return found;
}

/// The devices that the plugin lists or, if there are none, the reason.
DeviceList listed() {
  DeviceList list;
  try {
    const Backend& found = backend();
    if (!found.plugin)
      list.problem = found.problem;
    else
      list = found.plugin->devices();
  } catch (const std::exception& error) {
    list = {};
    list.problem = sentence(std::string("The devices cannot be listed: ") + error.what());
  }
  if (list.devices.empty() && list.problem.empty()) list.problem = "The CUDA backend finds no device.";
  return list;
}

constexpr std::int64_t kManySamples = 8'000'000; // from here on a device pays off

/// Milliseconds per iteration over a million samples on two cores (Docs/benchmarks.md), and the seconds of a
/// fit up to which "auto" stays on the CPU.
constexpr double kMillisecondsPerMillionSamples = 14, kSmall = 0.5;

} // namespace

DeviceList otherDevices() {
  DeviceList list = listed();
  for (std::size_t n = 0; n < list.devices.size(); ++n) {
    DeviceInfo& info = list.devices[n];
    try {
      DevicePlugin& plugin = *backend().plugin;
      info.refused = validateDevice(plugin, static_cast<int>(n), info.name, {}).refused;
      info.freeMemory = plugin.freeMemory(static_cast<int>(n));
    } catch (const std::exception& error) {
      if (info.refused.empty()) info.refused = sentence(info.name + " cannot be used: " + error.what());
    }
  }
  return list;
}

DeviceChoice::DeviceChoice(const std::string& asked, const std::string& instructionSet, Selection selection) {
  const DeviceRequest request = parseDeviceRequest(asked);
  use.asked = asked;
  if (request.kind == DeviceRequest::Kind::Cpu) {
    use.reason = "On the CPU, as asked.";
    return;
  }
  std::string only; // set if only the CPU supports it
  if (selection != Selection::Exact)
    only = std::string("the candidate selection ") + selectionName(selection);
  else if (!instructionSet.empty())
    only = "the instruction set " + instructionSet;
  if (!only.empty()) {
    if (request.kind == DeviceRequest::Kind::Cuda)
      throw Error(ErrorCode::InvalidArgument, "Only the CPU supports " + only + ": omit it, or the device.");
    use.reason = "On the CPU, which alone supports " + only + ".";
    return;
  }
  insists_ = request.kind == DeviceRequest::Kind::Cuda;
  const DeviceList list = listed();
  const int count = static_cast<int>(list.devices.size());
  if (count == 0) {
    if (insists_) throw Error(ErrorCode::InvalidArgument, "There is no CUDA device. " + list.problem);
    use.reason = "On the CPU. " + list.problem;
    return;
  }
  if (request.index >= count)
    throw Error(ErrorCode::InvalidArgument, "There is no device '" + asked +
                                                "': the last one is cuda:" + std::to_string(count - 1) + ".");
  std::vector<int> order; // most memory first
  for (int n = 0; n < count; ++n)
    if (request.index < 0 || request.index == n) order.push_back(n);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return list.devices[a].totalMemory > list.devices[b].totalMemory; });
  plugin_ = backend().plugin;
  std::string refused;
  for (int n : order) {
    const std::string why = knownRefusal(n);
    if (why.empty())
      candidates_.push_back({n, list.devices[n].name});
    else
      refused += (refused.empty() ? "" : " ") + why;
  }
  pass(refused, true);
}

/// Moves on to the next candidate; `why`: what ruled out the last one. `disagrees`: its results differ from
/// the CPU's.
void DeviceChoice::pass(const std::string& why, bool disagrees) {
  if (!why.empty()) passed_ += (passed_.empty() ? "" : " ") + why;
  onlyDisagree_ = onlyDisagree_ && disagrees;
  if (candidates_.empty()) {
    if (insists_ && onlyDisagree_) throw Error(ErrorCode::InvalidArgument, passed_ + " Use the CPU.");
    leave(passed_);
    return;
  }
  index_ = candidates_.front().index;
  use.id = "cuda:" + std::to_string(index_);
  use.name = candidates_.front().name;
  candidates_.erase(candidates_.begin());
  use.reason = "On " + label() + (insists_ ? ", as asked." : ", the GPU found.");
  if (!passed_.empty()) use.reason += " " + passed_;
}

/// Starts the device; if it disagrees with the CPU, moves on to the next.
void DeviceChoice::validate(const std::stop_token& stop) {
  while (!onCpu()) {
    const DeviceValidation validation = validateDevice(*plugin_, index_, use.name, stop);
    if (validation.refused.empty()) return;
    pass(validation.refused, validation.lasting);
  }
}

std::string DeviceChoice::label() const {
  return use.name + " (" + use.id + ")";
}

void DeviceChoice::leave(const std::string& why) {
  use.id = "cpu";
  use.name = "CPU";
  use.reason = "On the CPU. " + why;
  plugin_ = nullptr;
}

void DeviceChoice::failed(const std::string& how, const std::string& why) {
  leave(label() + " failed " + how + ": " + why);
}

void DeviceChoice::considerSize(const FitRequest& request) {
  double samples = 0;
  for (const Observation& o : *request.observations)
    samples += static_cast<double>(o.samples);
  considerSize(samples, request.iterations);
}

void DeviceChoice::considerSize(double samples, int iterations) {
  if (onCpu() || use.asked != "auto" || iterations <= 0) return;
  const double seconds = 1e-9 * kMillisecondsPerMillionSamples * samples * iterations;
  if (seconds > kSmall) return;
  leave(formatted("The fit is small: about %.1g s of work, not worth starting a GPU.",
                  std::max(seconds, 0.001)));
}

bool DeviceChoice::note(const std::string& remark) {
  if (remark.empty() || onCpu() || use.reason.find(remark) != std::string::npos) return false;
  use.reason += " " + remark;
  return true;
}

std::unique_ptr<FitDevice> DeviceChoice::makeFit(const FitRequest& request) {
  while (!onCpu()) {
    try {
      validate(request.stop);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Cancelled) leave("Stopped before " + label() + " was ready.");
      throw;
    }
    if (onCpu()) break;
    std::string why;
    try {
      const std::int64_t needed = plugin_->fitMemory(request), free = plugin_->freeMemory(index_);
      if (needed <= free) {
        std::unique_ptr<FitDevice> fit = plugin_->makeFit(index_, request);
        if (!fit) throw Error(ErrorCode::Internal, "it offers no fit.");
        const std::size_t before = memory_.empty() ? std::string::npos : use.reason.find(memory_);
        if (before != std::string::npos) use.reason.erase(before, memory_.size());
        memory_ = " The fit needs about " + bytesText(static_cast<double>(needed)) + " of its " +
                  bytesText(static_cast<double>(free)) + " of free memory.";
        use.reason += memory_;
        note(fit->remark());
        return fit;
      }
      why = "The fit needs about " + bytesText(static_cast<double>(needed)) + " on " + label() +
            ", which has " + bytesText(static_cast<double>(free)) + " free.";
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Cancelled) throw;
      why = sentence(label() + " cannot be used: " + error.what());
    } catch (const std::exception& error) {
      why = sentence(label() + " cannot be used: " + error.what());
    }
    pass(why, false);
  }
  return nullptr;
}

std::shared_ptr<FieldDevice> DeviceChoice::makeField(const GaussianField& field,
                                                     const std::stop_token& stop) {
  validate(stop);
  if (onCpu()) return nullptr;
  try {
    return plugin_->makeField(index_, field);
  } catch (const std::exception&) {
    return nullptr; // the CPU gives the same rendering
  }
}

std::unique_ptr<FeatureDevice> DeviceChoice::makeFeatures(const FeatureProblem& problem,
                                                          const std::stop_token& stop) {
  validate(stop);
  if (onCpu()) return nullptr;
  try {
    return plugin_->makeFeatures(index_, problem);
  } catch (const std::exception& error) {
    leave(sentence(label() + " cannot be used: " + error.what()));
    return nullptr;
  }
}

std::shared_ptr<FieldDevice> renderingDevice(const std::string& asked, const GaussianField& field,
                                             std::int64_t samples, const std::string& instructionSet,
                                             Selection selection, std::string* problem) {
  if (asked == "auto" && samples < kManySamples) return nullptr;
  DeviceChoice choice(asked, instructionSet, selection);
  std::shared_ptr<FieldDevice> device = choice.makeField(field);
  if (!device && !choice.onCpu() && problem)
    *problem = choice.use.name + " (" + choice.use.id + ") cannot hold the model: rendered on the CPU.";
  return device;
}

} // namespace innergs
