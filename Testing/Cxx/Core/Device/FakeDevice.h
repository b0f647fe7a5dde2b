#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"
#include "JobInputs.h"

#include <cstdlib>

namespace innergs::testing {

inline void setVariable(const char* name, const std::string& value) {
#ifdef _WIN32
  _putenv_s(name, value.c_str());
#else
  setenv(name, value.c_str(), 1);
#endif
}

/// Tests with the fake plugin (FakePlugin.cxx); fails(...) sets what fails from now on.
class FakeDevice : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    setVariable("INNERGS_PLUGIN_PATH", INNERGS_FAKE_PLUGINS "/good");
    fails("");
    otherDevices(); // checks them before anything fails
  }
  void SetUp() override { fails(""); }
  void TearDown() override { fails(""); }
  static void fails(const std::string& how) { setVariable("INNERGS_FAKE", how); }

  static Settings on(const std::string& device, Settings settings = quickSettings()) {
    settings.device = device;
    return settings;
  }
  /// The CPU with the fake's instruction set: bit-identical.
  static Settings reference(Settings settings = quickSettings()) {
    settings.device = "cpu";
    settings.instructionSet = "scalar";
    return settings;
  }
};

} // namespace innergs::testing
