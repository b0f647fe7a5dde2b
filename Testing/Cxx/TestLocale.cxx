// Linked into every GoogleTest program: INNERGS_TEST_LOCALE runs its tests in a host with that locale.
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <locale>
#include <stdexcept>

namespace {

class HostLocale : public testing::Environment {
public:
  void SetUp() override {
    const char* name = std::getenv("INNERGS_TEST_LOCALE");
    if (!name || !*name) return;
    try {
      std::locale::global(std::locale(name)); // C's as well
    } catch (const std::runtime_error&) {
      GTEST_FAIL() << "This system lacks the locale " << name << ": Utilities/make-locale.sh makes it.";
    }
    ASSERT_STREQ(std::localeconv()->decimal_point, ",") << name << " is to have a decimal comma";
  }
  void TearDown() override { std::locale::global(std::locale::classic()); }
};

const auto* const hostLocale = testing::AddGlobalTestEnvironment(new HostLocale);

} // namespace
