#pragma once
#include <optional>
#include <string>

namespace innergs {

/// While an instance lives, the C functions of the calling thread read and write numbers with a decimal
/// point, whatever the program's locale.
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
/// Formats like std::printf in the C locale.
std::string
formatted(const char* pattern, ...);

/// For messages: six significant digits ("0.9", "1e-06").
std::string numberText(double value);

/// The fewest significant digits that read back as the value ("0.1", "0.3333333333333333").
std::string exactText(double value);

/// The number, if the whole text is one ("nan" and "inf" included); nothing otherwise.
std::optional<double> wholeTextNumber(const std::string& text);

/// The number that a text begins with, after blanks, parsed like std::strtod in the C locale ("nan" and "inf"
/// included), and its length in characters.
std::optional<double> leadingNumber(const std::string& text, std::size_t* length = nullptr);

} // namespace innergs
