// A library with a plugin's stamp but no plugin.
#include "Core/Device/DevicePlugin.h"

extern "C" INNERGS_PLUGIN_EXPORT const innergs::PluginStamp* innergsPluginStamp() {
  static constexpr innergs::PluginStamp stamp{innergs::kPluginAbi, innergs::pluginLayout(), ""};
  return &stamp;
}
