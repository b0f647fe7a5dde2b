#pragma once
#include <optional>
#include <string>

namespace innergs {

/// While it lives, the calling thread's C functions read and write numbers with a decimal point, whatever
/// locale the program has set.
class ClassicNumbers {
public:
  ClassicNumbers();
  ~ClassicNumbers();
  ClassicNumbers(const ClassicNumbers&) = delete;
  ClassicNumbers& operator=(const ClassicNumbers&) = delete;

private:
#if defined(_WIN32)
  int perThread_;
  std::string before_;
#else
  void* before_;
#endif
};

#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
/// What std::printf would print in the C locale.
std::string
formatted(const char* pattern, ...);

/// For sentences: six significant digits ("0.9", "1e-06").
std::string numberText(double value);

/// The fewest significant digits that read back as the value ("0.1", "0.3333333333333333").
std::string exactText(double value);

/// The number that the whole text is, "nan" and "inf" too; nothing for any other text.
std::optional<double> wholeTextNumber(const std::string& text);

/// The number that a text begins with, blanks skipped, as std::strtod takes it in the C locale ("nan" and
/// "inf" too), and how long it is.
std::optional<double> leadingNumber(const std::string& text, std::size_t* length = nullptr);

} // namespace innergs
