#include "Core/Base/Failure.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <stdexcept>

using namespace innergs;

namespace {

template <class Thrown>
Failure thrown(const Thrown& what) {
  try {
    throw what;
  } catch (...) {
    return failureOf();
  }
}

} // namespace

TEST(Failure, KeepsTheSentenceOfAnError) {
  const Failure failure = thrown(Error(ErrorCode::Geometry, "The scans do not overlap: choose others."));
  EXPECT_EQ(failure.code, ErrorCode::Geometry);
  EXPECT_EQ(failure.sentence, "The scans do not overlap: choose others.");
}

TEST(Failure, SaysWhereMemoryIsMissing) {
  for (const Failure& failure : {thrown(std::bad_alloc()), thrown(std::length_error("vector::reserve"))}) {
    EXPECT_EQ(failure.code, ErrorCode::Memory);
    EXPECT_EQ(failure.sentence.find("There is not enough memory: close other programs"), 0u);
  }
}

TEST(Failure, NoTextOfTheLibraryStandsAlone) {
  const Failure file = thrown(
      std::filesystem::filesystem_error("cannot copy", std::make_error_code(std::errc::no_space_on_device)));
  EXPECT_EQ(file.code, ErrorCode::Io);
  EXPECT_NE(file.sentence.find("try again."), std::string::npos);
  const Failure other = thrown(std::runtime_error("first line\nsecond"));
  EXPECT_EQ(other.code, ErrorCode::Internal);
  EXPECT_NE(other.sentence.find("(first line second)"), std::string::npos) << other.sentence;
  EXPECT_EQ(thrown(7).sentence, "Unexpected failure: please report it with these data and settings.");
}

TEST(Failure, OfATask) {
  EXPECT_EQ(sentenceOf([] {}), "");
  EXPECT_EQ(sentenceOf([] { throw Error(ErrorCode::Io, "The disk is full: make room."); }),
            "The disk is full: make room.");
}
