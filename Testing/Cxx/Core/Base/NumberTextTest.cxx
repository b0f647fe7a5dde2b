#include "Core/Base/NumberText.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <limits>

using namespace innergs;

TEST(NumberText, HasAPointInEveryLocale) {
  EXPECT_EQ(formatted("%.2f mm, %d of %s", 1234.5, 7, "ten"), "1234.50 mm, 7 of ten");
  EXPECT_EQ(formatted("%.17g", 0.1), "0.10000000000000001");
  EXPECT_EQ(formatted("%s", std::string(5000, 'x').c_str()).size(), 5000u);
}

TEST(NumberText, IsReadWithAPointInEveryLocale) {
  EXPECT_EQ(leadingNumber("4.5"), 4.5);
  EXPECT_EQ(leadingNumber(" -1.25e2 mm"), -125.0);
  EXPECT_EQ(leadingNumber("4,5"), 4.0);
  EXPECT_EQ(leadingNumber("none"), std::nullopt);
  EXPECT_EQ(leadingNumber(""), std::nullopt);
  EXPECT_TRUE(std::isnan(leadingNumber("NaN").value()));
  EXPECT_EQ(leadingNumber("-inf"), -std::numeric_limits<double>::infinity());
}

TEST(NumberText, LeavesTheProgramsLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr), point = std::localeconv()->decimal_point;
  {
    const ClassicNumbers outer;
    EXPECT_STREQ(std::localeconv()->decimal_point, ".");
    { const ClassicNumbers inner; }
    EXPECT_STREQ(std::localeconv()->decimal_point, ".");
  }
  EXPECT_EQ(std::setlocale(LC_ALL, nullptr), before);
  EXPECT_EQ(std::localeconv()->decimal_point, point);
}
