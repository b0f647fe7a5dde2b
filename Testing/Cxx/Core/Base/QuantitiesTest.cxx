#include "Core/Base/Quantities.h"

#include <gtest/gtest.h>

using namespace innergs;

TEST(Quantities, SaysBytesInTheUnitThatSuits) {
  EXPECT_EQ(bytesText(10), "1 kB");
  EXPECT_EQ(bytesText(25'600), "26 kB");
  EXPECT_EQ(bytesText(999'600), "1 MB");
  EXPECT_EQ(bytesText(64e6), "64 MB");
  EXPECT_EQ(bytesText(999.6e6), "1.0 GB");
  EXPECT_EQ(bytesText(38.24e9), "38.2 GB");
  EXPECT_EQ(bytesText(120e9), "120 GB");
}

TEST(Quantities, GroupsTheDigitsOfCounts) {
  EXPECT_EQ(countText(0), "0");
  EXPECT_EQ(countText(999), "999");
  EXPECT_EQ(countText(1'045'528), "1,045,528");
  EXPECT_EQ(countText(-123'456), "-123,456");
}

TEST(Quantities, SaysLengthsToThreeDigits) {
  EXPECT_EQ(lengthText(0.9), "0.9");
  EXPECT_EQ(lengthText(4), "4");
  EXPECT_EQ(lengthText(8. / 3), "2.67");
  EXPECT_EQ(lengthText(1250.4), "1250");
}
