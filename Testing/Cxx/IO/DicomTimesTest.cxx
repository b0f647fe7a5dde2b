#include "IO/DicomTimes.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

using Texts = std::vector<std::string>;
using Times = std::vector<double>;

TEST(DicomTimes, AreSecondsAfterMidnight) {
  EXPECT_EQ(dicomSliceTimes(Texts{"080001", "090203.5 ", "101559"}, {}), (Times{28801, 32523.5, 36959}));
  EXPECT_EQ(dicomSliceTimes(Texts{"235950", "000010"}, {}), (Times{86390, 86410})) << "past midnight";
}

TEST(DicomTimes, AreThoseOfTheTriggerWhereTheAcquisitionsSayNothing) {
  const Texts triggers{"0 ", "1500"};
  EXPECT_EQ(dicomSliceTimes({}, triggers), (Times{0, 1.5}));
  EXPECT_EQ(dicomSliceTimes(Texts{"101500", ""}, triggers), (Times{0, 1.5}));
  EXPECT_EQ(dicomSliceTimes(Texts{"101500", "101500"}, triggers), (Times{0, 1.5})) << "all the same";
  EXPECT_EQ(dicomSliceTimes(Texts{"101500", "101501"}, triggers), (Times{36900, 36901}));
  EXPECT_TRUE(dicomSliceTimes(Texts{"noon", "later"}, Texts{"5", "5"}).empty());
  EXPECT_TRUE(dicomSliceTimes({}, {}).empty());
}

} // namespace
} // namespace innergs
