#include "Core/Device/DeviceValidation.h"

#include "Core/Base/StopToken.h"
#include "Core/Device/DeviceCheck.h"

#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>

namespace innergs {
namespace {

using namespace std::chrono_literals;

struct Validations {
  std::mutex mutex;
  std::map<int, std::string> known; // refusals, also empty ones
  std::map<int, std::shared_future<DeviceValidation>> running;
  std::atomic<int> active{0};
};

/// Never destroyed, as a comparison may outlive main().
Validations& validations() {
  static Validations* all = new Validations;
  return *all;
}

/// At exit, waits for devices at work before their driver is unloaded, but not for one that hangs.
struct WaitAtExit {
  ~WaitAtExit() {
    for (int n = 0; n < 100 && validations().active > 0; ++n)
      std::this_thread::sleep_for(20ms);
  }
};

DeviceValidation compare(DevicePlugin& plugin, int device, const std::string& name) {
  DeviceValidation validation;
  std::string why;
  try {
    why = deviceDisagreement(plugin, device);
  } catch (const std::exception& error) {
    validation.lasting = false;
    why = std::string("it failed: ") + error.what();
  } catch (...) {
    validation.lasting = false;
    why = "it failed";
  }
  if (why.empty()) return validation;
  while (why.back() == '.')
    why.pop_back();
  validation.refused =
      name + " (cuda:" + std::to_string(device) + ") is not used: in its self-check, " + why + ".";
  return validation;
}

} // namespace

DeviceValidation validateDevice(DevicePlugin& plugin, int device, const std::string& name,
                                const std::stop_token& stop) {
  Validations& all = validations();
  static const WaitAtExit waitAtExit;
  std::shared_future<DeviceValidation> result;
  {
    const std::lock_guard lock(all.mutex);
    const auto known = all.known.find(device);
    if (known != all.known.end()) return {known->second, true};
    const auto running = all.running.find(device);
    if (running != all.running.end()) {
      result = running->second;
    } else {
      std::promise<DeviceValidation> promise;
      result = promise.get_future().share();
      std::thread worker;
      try {
        worker = std::thread([&all, &plugin, device, name, promise = std::move(promise)]() mutable {
          const DeviceValidation validation = compare(plugin, device, name);
          {
            const std::lock_guard done(all.mutex); // waits until it counts as running
            if (validation.lasting) all.known[device] = validation.refused;
            all.running.erase(device);
          }
          promise.set_value(validation);
          --all.active;
        });
      } catch (const std::system_error&) {
        return {name + " (cuda:" + std::to_string(device) +
                    ") is not used: the system could not start the thread of its self-check.",
                false};
      }
      ++all.active;
      all.running[device] = result;
      worker.detach();
    }
  }
  while (result.wait_for(10ms) != std::future_status::ready)
    throwIfStopped(stop);
  return result.get();
}

std::string knownRefusal(int device) {
  Validations& all = validations();
  const std::lock_guard lock(all.mutex);
  const auto known = all.known.find(device);
  return known == all.known.end() ? std::string() : known->second;
}

} // namespace innergs
