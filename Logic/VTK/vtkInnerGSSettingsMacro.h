#ifndef vtkInnerGSSettingsMacro_h
#define vtkInnerGSSettingsMacro_h

#include <string> // returned

/// One setting as a number, for scripts that set it often. A choice is the index of its word; Automatic means
/// unset. The range is checked on use.
#define vtkInnerGSSettingMacro(Property, name, Type)                                                         \
  void Set##Property(Type value) {                                                                           \
    this->SetSettingNumber(#name, static_cast<double>(value));                                               \
  }                                                                                                          \
  Type Get##Property() {                                                                                     \
    return static_cast<Type>(this->GetSettingNumber(#name));                                                 \
  }

/// One setting as text.
#define vtkInnerGSTextSettingMacro(Property, name)                                                           \
  void Set##Property(const std::string& text) {                                                              \
    this->SetSetting(#name, text);                                                                           \
  }                                                                                                          \
  std::string Get##Property() {                                                                              \
    return this->GetSetting(#name);                                                                          \
  }

/// Access to innergs::settingsTable() for a class with GetSettings() and SetSettings(). SettingsAccess.h has
/// the implementation.
///
/// SetSetting: by the names in Docs/settings.md; "" unsets, so that preset and data decide. What CheckSetting
/// rejects is an ErrorEvent and changes nothing. GetSetting: "" if unset.
/// CheckSetting: the message that rejects a text; "" if it is valid.
#define vtkInnerGSSettingsMacro()                                                                            \
  std::string GetSetting(const std::string& name);                                                           \
  bool UnsetSetting(const std::string& name) {                                                               \
    return this->SetSetting(name, "");                                                                       \
  }                                                                                                          \
  static std::string CheckSetting(const std::string& name, const std::string& text);                         \
  static int GetNumberOfSettings();                                                                          \
  static std::string GetSettingName(int index);                                                              \
  enum Presets { Fast, Balanced, Best, Paper }; /* Paper: the paper's Algorithm 1 */                         \
  enum Blendings { Normalised, Additive, Alpha };                                                            \
  enum { Automatic = -1 }; /* unset: chosen from preset and data */                                          \
  vtkInnerGSSettingMacro(Preset, preset, int);                                                               \
  vtkInnerGSSettingMacro(Blending, blending, int);                                                           \
  vtkInnerGSSettingMacro(LinearIntensity, linearIntensity, int);                                             \
  vtkInnerGSSettingMacro(NumberOfGaussians, gaussians, vtkIdType);                                           \
  vtkInnerGSSettingMacro(NumberOfIterations, iterations, int);                                               \
  vtkInnerGSSettingMacro(EnsembleSize, ensembleSize, int);                                                   \
  vtkInnerGSSettingMacro(FillValue, fill, double);                                                           \
  void SetSeed(vtkTypeUInt64 seed) {                                                                         \
    this->SetSetting("seed", std::to_string(seed));                                                          \
  }                                                                                                          \
  vtkTypeUInt64 GetSeed() {                                                                                  \
    return std::stoull(this->GetSetting("seed"));                                                            \
  }                                                                                                          \
  bool SetSetting(const std::string& name, const std::string& text)

#endif
