#pragma once
#include "Core/Features/FeatureDevice.h"
#include "Core/Fit/FitDevice.h"
#include "Core/Render/FieldDevice.h"

#include <span>
#include <string>

/// The interface of a device plugin: a shared library, found and loaded at run time (Devices.h), that
/// computes fits and renderings on hardware other than the CPU. C++ objects, exceptions and memory cross the
/// boundary, so plugin and program must come from the same build (compiler, standard library, source tree);
/// the stamp below is compared before any other call. Plugins are never unloaded.
namespace innergs {

struct DeviceInfo {
  std::string name;              // the manufacturer's name
  std::string computeCapability; // e.g. "9.0"
  std::int64_t totalMemory = 0;  // bytes
  std::int64_t freeMemory = 0;   // bytes, now; 0 from plugins, since it needs the device started
  std::string refused;           // one sentence if its results disagree with the CPU's, else empty
};

struct DeviceList {
  std::vector<DeviceInfo> devices; // number N is "cuda:N"
  std::string problem;             // one sentence if there is none: no driver, driver too old, no device
};

/// Throws innergs::Error with one sentence, Error(Memory) if the device has too little. All functions may be
/// called from any thread; each object made is used by one thread at a time.
class DevicePlugin {
public:
  virtual ~DevicePlugin() = default;
  /// Never throws. Queries the driver at every call and starts no device.
  virtual DeviceList devices() = 0;
  /// Free bytes now. Starts the device.
  virtual std::int64_t freeMemory(int device) = 0;
  /// Bytes of device memory that the fit needs to complete.
  virtual std::int64_t fitMemory(const FitRequest& request) = 0;
  virtual std::unique_ptr<FitDevice> makeFit(int device, const FitRequest& request) = 0;
  /// Copies the field (its Gaussians and numbers, not the residual grid) to the device.
  virtual std::unique_ptr<FieldDevice> makeField(int device, const GaussianField& field) = 0;
  /// Copies what features are learned from to the device.
  virtual std::unique_ptr<FeatureDevice> makeFeatures(int device, const FeatureProblem& problem) = 0;
};

/// Increased with every change of what crosses the boundary.
constexpr std::uint32_t kPluginAbi = 5;

/// Plain data, readable by any two builds.
struct PluginStamp {
  std::uint32_t abi;
  std::uint32_t layout; // hash of the sizes of all that crosses the boundary
  const char* build;    // version and compiler family
};

// Internal linkage on purpose: a shared function could resolve to the other side's.
static constexpr std::uint32_t pluginLayout() {
  std::uint32_t hash = 2166136261u;
  for (std::size_t size :
       {sizeof(void*),         sizeof(std::string), sizeof(std::vector<float>),  sizeof(Gaussian),
        sizeof(GaussianField), sizeof(Adam),        sizeof(GradientAccumulator), sizeof(Observation),
        sizeof(SampleGrid),    sizeof(FitRules),    sizeof(IterationOptions),    sizeof(RelocationPlan),
        sizeof(DensifyCounts), sizeof(LossSum),     sizeof(FitRequest),          sizeof(FeatureProblem),
        sizeof(FeatureRows),   sizeof(FeatureStep), sizeof(SoftLabel),           sizeof(DeviceInfo),
        sizeof(DeviceList)})
    hash = (hash ^ static_cast<std::uint32_t>(size)) * 16777619u;
  return hash;
}

#if defined(_MSC_VER)
#define INNERGS_PLUGIN_COMPILER "msvc"
#elif defined(_LIBCPP_VERSION)
#define INNERGS_PLUGIN_COMPILER "libc++"
#else
#define INNERGS_PLUGIN_COMPILER "libstdc++"
#endif

#ifdef _WIN32
#define INNERGS_PLUGIN_EXPORT __declspec(dllexport)
#else
#define INNERGS_PLUGIN_EXPORT __attribute__((visibility("default")))
#endif

/// The two functions that a plugin exports: its stamp, and the plugin itself (owned by the library, valid to
/// the end of the program; refused if null or if it throws).
constexpr const char* kPluginStampSymbol = "innergsPluginStamp";
constexpr const char* kPluginSymbol = "innergsDevicePlugin";
using PluginStampFunction = const PluginStamp* (*)();
using PluginFunction = DevicePlugin* (*)();

} // namespace innergs

/// Defines both for a plugin class with a default constructor. The CMake target innergs_plugin, which plugins
/// link, provides INNERGS_PLUGIN_VERSION.
#define INNERGS_DEVICE_PLUGIN(Class)                                                                         \
  extern "C" INNERGS_PLUGIN_EXPORT const innergs::PluginStamp* innergsPluginStamp() {                        \
    static constexpr innergs::PluginStamp stamp{innergs::kPluginAbi, innergs::pluginLayout(),                \
                                                INNERGS_PLUGIN_VERSION " " INNERGS_PLUGIN_COMPILER};         \
    return &stamp;                                                                                           \
  }                                                                                                          \
  extern "C" INNERGS_PLUGIN_EXPORT innergs::DevicePlugin* innergsDevicePlugin() {                            \
    static Class plugin;                                                                                     \
    return &plugin;                                                                                          \
  }
