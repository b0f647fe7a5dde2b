#include "Core/Base/SystemMemory.h"

#include <gtest/gtest.h>

#include <vector>

using namespace innergs;

TEST(SystemMemory, RemembersTheMostThatWasResident) {
  constexpr std::size_t size = 64 << 20;
  { const std::vector<char> touched(size, 1); }
  EXPECT_GE(peakMemory(), static_cast<std::int64_t>(size));
}
