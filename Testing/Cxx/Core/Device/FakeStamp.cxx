// A library that stamps itself as a plugin and offers none.
#include "Core/Device/DevicePlugin.h"

extern "C" INNERGS_PLUGIN_EXPORT const innergs::PluginStamp* innergsPluginStamp() {
  static constexpr innergs::PluginStamp stamp{innergs::kPluginAbi, innergs::pluginLayout(), ""};
  return &stamp;
}
