#include "Core/Base/NumberText.h"

#include <clocale>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#if defined(_WIN32)
#include <locale.h>
#else
#include <locale.h>
#if defined(__APPLE__)
#include <xlocale.h>
#endif
#endif

namespace innergs {

#if defined(_WIN32)
ClassicNumbers::ClassicNumbers()
    : perThread_(_configthreadlocale(_ENABLE_PER_THREAD_LOCALE)),
      before_(std::setlocale(LC_NUMERIC, nullptr)) {
  std::setlocale(LC_NUMERIC, "C");
}

ClassicNumbers::~ClassicNumbers() {
  std::setlocale(LC_NUMERIC, before_.c_str());
  _configthreadlocale(perThread_);
}
#else
ClassicNumbers::ClassicNumbers() {
  static const locale_t classic = newlocale(LC_ALL_MASK, "C", nullptr);
  before_ = uselocale(classic);
}

ClassicNumbers::~ClassicNumbers() {
  uselocale(static_cast<locale_t>(before_));
}
#endif

std::string formatted(const char* pattern, ...) {
  const ClassicNumbers classic;
  std::va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  return text;
}

std::string numberText(double value) {
  return formatted("%g", value);
}

std::string exactText(double value) {
  std::string text;
  for (int digits = 15; digits <= 17; ++digits) {
    text = formatted("%.*g", digits, value);
    if (leadingNumber(text) == value) break;
  }
  return text;
}

std::optional<double> leadingNumber(const std::string& text, std::size_t* length) {
  const ClassicNumbers classic;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (length) *length = static_cast<std::size_t>(end - text.c_str());
  if (end == text.c_str()) return std::nullopt;
  return value;
}

std::optional<double> wholeTextNumber(const std::string& text) {
  std::size_t length = 0;
  const auto value = leadingNumber(text, &length);
  return length == text.size() ? value : std::nullopt;
}

} // namespace innergs
