#pragma once
#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Settings/SettingsTable.h"

#include <string>

/// Implements vtkInnerGSSettingsMacro().
#define vtkInnerGSSettingsAccessMacro(Class)                                                                 \
  bool Class::SetSetting(const std::string& name, const std::string& text) {                                 \
    return innergs::vtk::change(this,                                                                        \
                                [&](innergs::Settings& s) { s = innergs::vtk::checked(s, name, text); });    \
  }                                                                                                          \
  std::string Class::GetSetting(const std::string& name) {                                                   \
    std::string text;                                                                                        \
    const std::string refusal =                                                                              \
        innergs::sentenceOf([&] { text = innergs::settingNamed(name).textIn(this->GetSettings()); });        \
    if (!refusal.empty()) vtkErrorMacro(<< refusal);                                                         \
    return text;                                                                                             \
  }                                                                                                          \
  std::string Class::CheckSetting(const std::string& name, const std::string& text) {                        \
    return innergs::sentenceOf([&] { innergs::vtk::checked({}, name, text); });                              \
  }                                                                                                          \
  int Class::GetNumberOfSettings() {                                                                         \
    return static_cast<int>(innergs::settingsTable().size());                                                \
  }                                                                                                          \
  std::string Class::GetSettingName(int index) {                                                             \
    return index >= 0 && index < GetNumberOfSettings() ? innergs::settingsTable()[index].name : "";          \
  }                                                                                                          \
  void Class::SetSettingNumber(const char* name, double number) {                                            \
    innergs::vtk::change(this, [&](innergs::Settings& s) {                                                   \
      const innergs::Setting& row = innergs::settingNamed(name);                                             \
      const bool unset = row.member.optional && number == -1;                                                \
      row.setNumber(s, unset ? std::nullopt : std::optional(number));                                        \
    });                                                                                                      \
  }                                                                                                          \
  double Class::GetSettingNumber(const char* name) {                                                         \
    return innergs::settingNamed(name).numberIn(this->GetSettings()).value_or(-1);                           \
  }

namespace innergs::vtk {

inline Settings checked(Settings settings, const std::string& name, const std::string& text) {
  const Setting& row = settingNamed(name);
  row.setText(settings, text);
  row.check(settings);
  return settings;
}

/// Changes the object's settings; reports an exception as an ErrorEvent. Returns whether there was none.
template <class Object, class Edit>
bool change(Object* self, Edit edit) {
  Settings settings = self->GetSettings();
  const std::string refusal = sentenceOf([&] { edit(settings); });
  if (refusal.empty())
    self->SetSettings(settings);
  else
    vtkErrorWithObjectMacro(self, << refusal);
  return refusal.empty();
}

} // namespace innergs::vtk

/// The same for a class whose member Choices points to its settings.
#define vtkInnerGSOwnSettingsMacro(Class)                                                                    \
  vtkInnerGSSettingsAccessMacro(Class) const innergs::Settings& Class::GetSettings() const {                 \
    return *this->Choices;                                                                                   \
  }                                                                                                          \
  void Class::SetSettings(const innergs::Settings& settings) {                                               \
    if (settings == *this->Choices) return;                                                                  \
    *this->Choices = settings;                                                                               \
    this->Modified();                                                                                        \
  }

/// The same for a filter, whose device, threads and instruction set are its own members.
#define vtkInnerGSFilterSettingsMacro(Class)                                                                 \
  vtkInnerGSSettingsAccessMacro(Class) innergs::Settings Class::GetSettings() const {                        \
    innergs::Settings settings = this->Work->settings;                                                       \
    settings.device = this->Device;                                                                          \
    settings.threads = this->NumberOfThreads;                                                                \
    settings.instructionSet = this->InstructionSet;                                                          \
    return settings;                                                                                         \
  }                                                                                                          \
  void Class::SetSettings(const innergs::Settings& settings) {                                               \
    if (settings == this->GetSettings()) return;                                                             \
    this->Work->settings = settings;                                                                         \
    this->Device = settings.device;                                                                          \
    this->NumberOfThreads = settings.threads;                                                                \
    this->InstructionSet = settings.instructionSet;                                                          \
    this->Modified();                                                                                        \
  }
