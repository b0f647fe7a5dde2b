#include "Core/Settings/Setting.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"

#include <charconv>
#include <cmath>

namespace innergs {
namespace {

template <class Whole>
std::optional<Whole> wholeNumber(const std::string& text) {
  Whole value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, problem] = std::from_chars(text.data(), end, value);
  if (problem == std::errc::invalid_argument || stopped != end) return {};
  if (problem == std::errc()) return value;
  return text.front() == '-' ? std::numeric_limits<Whole>::min() : std::numeric_limits<Whole>::max();
}

std::string boundText(const Setting& row, double bound) {
  return row.type() == Setting::Type::Integer ? countText(std::llround(bound)) : numberText(bound);
}

[[noreturn]] void refuse(const std::string& sentence) {
  throw Error(ErrorCode::InvalidArgument, sentence);
}

} // namespace

bool SettingRange::contains(double x) const {
  return std::isfinite(x) && (open ? x > lowest : x >= lowest) && (openHigh ? x < highest : x <= highest);
}

std::string Setting::option() const {
  std::string text;
  for (const char* c = name; *c; ++c) {
    const bool capital = *c >= 'A' && *c <= 'Z';
    if (capital) text += '-';
    text += static_cast<char>(capital ? *c - 'A' + 'a' : *c);
  }
  return text;
}

std::string Setting::rangeText() const {
  if (type() == Type::Flag) return "true or false";
  if (type() == Type::Choice) {
    std::string text;
    for (const SettingWord& word : words)
      text += (text.empty() ? "one of " : "|") + std::string(word.name);
    return text;
  }
  const bool low = std::isfinite(range.lowest), high = std::isfinite(range.highest);
  if (low && high && !range.open && !range.openHigh)
    return "between " + boundText(*this, range.lowest) + " and " + boundText(*this, range.highest);
  std::string text;
  if (low) text = (range.open ? "above " : "at least ") + boundText(*this, range.lowest);
  if (high)
    text += (low ? " and " : "") + std::string(range.openHigh ? "below " : "at most ") +
            boundText(*this, range.highest);
  return text;
}

bool Setting::isIn(const Settings& settings) const {
  return member.get(settings).index() != 0;
}

bool Setting::hasEffectIn(const Settings& settings) const {
  return !applies || applies(withPresetValues(settings));
}

std::string Setting::textIn(const Settings& settings) const {
  return std::visit(
      [this](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::monostate>)
          return "";
        else if constexpr (std::is_same_v<Value, std::string>)
          return value;
        else if constexpr (std::is_same_v<Value, bool>)
          return value ? "true" : "false";
        else if constexpr (std::is_same_v<Value, double>)
          return exactText(value);
        else
          return words.empty() ? std::to_string(value) : words.at(static_cast<std::size_t>(value)).name;
      },
      member.get(settings));
}

void Setting::setText(Settings& settings, const std::string& text) const {
  if (text.empty()) return member.set(settings, {});
  const auto set = [&](const auto& value, const std::string& expected) {
    if (!value) refuse("The setting " + std::string(name) + " is " + expected + ", not '" + text + "'.");
    member.set(settings, *value);
  };
  std::optional<bool> flag;
  std::optional<std::int64_t> index;
  switch (type()) {
  case Type::Flag:
    if (text == "true" || text == "1") flag = true;
    if (text == "false" || text == "0") flag = false;
    return set(flag, rangeText());
  case Type::Choice:
    for (std::size_t n = 0; n < words.size(); ++n)
      if (text == words[n].name) index = static_cast<std::int64_t>(n);
    return set(index, rangeText());
  case Type::Integer:
    return set(wholeNumber<std::int64_t>(text), "a whole number");
  case Type::Natural:
    return set(wholeNumber<std::uint64_t>(text), "a whole number of 0 or more");
  case Type::Real:
    return set(wholeTextNumber(text), "a number");
  case Type::Text:
    if (checkText) checkText(text);
    member.set(settings, text);
  }
}

std::optional<double> Setting::numberIn(const Settings& settings) const {
  return std::visit(
      [](const auto& value) -> std::optional<double> {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>)
          return static_cast<double>(value);
        else
          return {};
      },
      member.get(settings));
}

void Setting::setNumber(Settings& settings, std::optional<double> number) const {
  if (!number) return member.set(settings, {});
  const double x = *number, whole = std::round(x);
  if (std::isnan(x) || type() == Type::Text || (type() == Type::Natural && !(x >= 0 && whole < 0x1p64)) ||
      (type() == Type::Choice && !(whole >= 0 && whole < static_cast<double>(words.size()))))
    refuse("The setting " + std::string(name) + " cannot be " + numberText(x) + ".");
  if (type() == Type::Flag) return member.set(settings, x != 0);
  if (type() == Type::Real) return member.set(settings, x);
  if (type() == Type::Natural) return member.set(settings, static_cast<std::uint64_t>(whole));
  member.set(settings, static_cast<std::int64_t>(std::clamp(whole, -0x1p62, 0x1p62)));
}

void Setting::check(const Settings& settings) const {
  if (checkText) checkText(textIn(settings));
  const bool number = type() == Type::Integer || type() == Type::Real;
  if (!number || !isIn(settings) || range.contains(*numberIn(settings))) return;
  std::string expected = rangeText();
  if (expected.empty()) expected = "a finite number";
  if (*unit) expected += std::string(" ") + unit;
  refuse(std::string(label) + " (" + name + ") must be " + expected + ", not " + textIn(settings) + ".");
}

} // namespace innergs
