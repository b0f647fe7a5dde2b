#pragma once
#include "Core/Settings/Settings.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace innergs {

/// A setting's value: nothing if it is unset; for a choice, the index of its word.
using SettingValue = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string>;

/// How a row of the table accesses its member of Settings.
struct SettingMember {
  enum class Type { Flag, Choice, Integer, Natural, Real, Text } type; // Natural: 64 bits without sign
  bool optional;                                                       // unset: chosen from preset and data
  SettingValue (*get)(const Settings&);
  void (*set)(Settings&, const SettingValue&); // of the type's alternative; nothing: restores the default
};

/// The allowed range of a number.
struct SettingRange {
  double lowest = -std::numeric_limits<double>::infinity(), highest = std::numeric_limits<double>::infinity();
  bool open = false;     // excludes the lowest value
  bool openHigh = false; // excludes the highest value
  bool contains(double x) const;
};

/// A choice's word, its label in panels, and its effect.
struct SettingWord {
  const char *name, *label;
  const char* text = "";
};

/// The optional parts of a row.
struct SettingNotes {
  /// What the setting affects: the fit, the result (made from the fit), or only the speed.
  enum class Part { Fit, Result, Speed } part = Part::Fit;
  SettingRange range = {};
  std::vector<SettingWord> words = {}; // of a choice, in the order of its enumeration
  const char* unit = "";
  const char* automatic = "";                 // what happens when unset, if the preset alone does not decide
  const char* zero = "";                      // what 0 means
  double usual = 0;                           // where a panel's steps start from automatic; 0: the lowest
  bool (*applies)(const Settings&) = nullptr; // whether it has an effect, given withPresetValues()
  void (*checkText)(const std::string&) = nullptr; // throws Error
  bool dynamic = false;                            // the fit of a dynamic scan uses it as well
};

/// One row of settingsTable(): everything that any layer shows or checks for one setting. Texts are English
/// and marked for translation in the context "innergs".
struct Setting : SettingNotes {
  /// Where panels and help list it; panels have a dedicated place for Basic ones.
  enum class Group { Basic, Model, Fit, LearningRates, Densification, Computation, Dynamic };

  Setting(const char* name, SettingMember member, Group group, const char* label, const char* text,
          SettingNotes notes = {})
      : SettingNotes(std::move(notes)), name(name), member(member), group(group), label(label), text(text) {}

  const char* name; // the only spelling; options are its kebab-case
  SettingMember member;
  Group group;
  const char *label, *text; // one or two sentences

  using Type = SettingMember::Type;
  Type type() const { return member.type; }
  /// "plateau-factor" for plateauFactor.
  std::string option() const;
  /// "between 1 and 5", "above 0", "one of l1|l2|huber", "true or false"; "" for any.
  std::string rangeText() const;
  bool isIn(const Settings& settings) const; // whether it is set
  bool hasEffectIn(const Settings& settings) const;

  /// "" if unset; round-trips exactly. The same in every locale.
  std::string textIn(const Settings& settings) const;
  /// The inverse; "" unsets. Does not check the range (see check()). Throws Error(InvalidArgument) if the
  /// text is no value of this type.
  void setText(Settings& settings, const std::string& text) const;
  /// A number, a flag as 0 or 1, or a choice's index; nothing if unset or a text setting.
  std::optional<double> numberIn(const Settings& settings) const;
  /// Throws Error(InvalidArgument) for NaN, for an index without a word, and for a text setting.
  void setNumber(Settings& settings, std::optional<double> number) const;
  /// Throws Error(InvalidArgument) with one sentence if the value is out of range.
  void check(const Settings& settings) const;
};

namespace detail {

template <class T>
struct SettingTraits : std::type_identity<T> {};
template <class T>
struct SettingTraits<std::optional<T>> : std::type_identity<T> {};

template <class Value>
constexpr SettingMember::Type settingType() {
  using Type = SettingMember::Type;
  if (std::is_same_v<Value, bool>) return Type::Flag;
  if (std::is_enum_v<Value>) return Type::Choice;
  if (std::is_same_v<Value, std::uint64_t>) return Type::Natural;
  if (std::is_integral_v<Value>) return Type::Integer;
  return std::is_same_v<Value, double> ? Type::Real : Type::Text;
}

template <class Value>
using StoredAs = std::conditional_t<settingType<Value>() == SettingMember::Type::Choice ||
                                        settingType<Value>() == SettingMember::Type::Integer,
                                    std::int64_t, Value>;

} // namespace detail

/// The member selected by a generic lambda, e.g. [](auto& s) -> auto& { return s.plateau.factor; }.
template <class Access>
SettingMember settingMember(Access) {
  using Member = std::decay_t<decltype(Access{}(std::declval<Settings&>()))>;
  using Value = typename detail::SettingTraits<Member>::type;
  using Stored = detail::StoredAs<Value>;
  const auto get = [](const Settings& settings) -> SettingValue {
    const auto& member = Access{}(settings);
    if constexpr (std::is_same_v<Member, Value>)
      return static_cast<Stored>(member);
    else
      return member ? SettingValue(static_cast<Stored>(*member)) : SettingValue();
  };
  const auto set = [](Settings& settings, const SettingValue& value) {
    auto& member = Access{}(settings);
    if (const Settings fresh; value.index() == 0) {
      member = Access{}(fresh);
      return;
    }
    Stored stored = std::get<Stored>(value);
    if constexpr (std::is_same_v<Value, int>) // a value that does not fit is out of every range
      stored = std::clamp<Stored>(stored, std::numeric_limits<int>::min(), std::numeric_limits<int>::max());
    member = static_cast<Value>(stored);
  };
  return {detail::settingType<Value>(), !std::is_same_v<Member, Value>, get, set};
}

} // namespace innergs
