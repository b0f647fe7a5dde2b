// Tests the replacement for std::stop_token on standard libraries without one.
#define INNERGS_COMPAT_NAMESPACE innergs_compat
#include INNERGS_COMPAT_STOP_TOKEN

#include <gtest/gtest.h>

#include <chrono>
#include <type_traits>

namespace {

using innergs_compat::jthread;
using innergs_compat::stop_source;
using innergs_compat::stop_token;

TEST(StopTokenCompat, TellsEveryTokenOfTheFirstRequest) {
  EXPECT_FALSE(stop_token().stop_requested());
  EXPECT_FALSE(stop_token().stop_possible());
  stop_source source;
  const stop_source copy = source;
  const stop_token token = source.get_token(), late = copy.get_token();
  EXPECT_TRUE(token.stop_possible());
  EXPECT_TRUE(token == late);
  EXPECT_FALSE(token == stop_source().get_token());
  EXPECT_FALSE(token.stop_requested());
  EXPECT_TRUE(source.request_stop());
  EXPECT_FALSE(source.request_stop());
  EXPECT_TRUE(copy.stop_requested());
  EXPECT_TRUE(late.stop_requested());
  source = stop_source(); // another one: the old tokens keep their state
  EXPECT_FALSE(source.stop_requested());
  EXPECT_TRUE(token.stop_requested());
}

TEST(StopTokenCompat, TokensOutliveTheirSource) {
  stop_token token;
  {
    stop_source source;
    token = source.get_token();
    source.request_stop();
  }
  EXPECT_TRUE(token.stop_requested());
}

TEST(StopTokenCompat, ThreadsAreStoppedAndJoined) {
  std::atomic<int> ended{0};
  const auto wait = [&](const stop_token& stop) {
    while (!stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++ended;
  };
  {
    jthread first(wait);
    EXPECT_TRUE(first.joinable());
    jthread second(std::move(first));
    EXPECT_FALSE(first.joinable()); // NOLINT(bugprone-use-after-move): tests the moved-from state
    second = jthread(wait);         // ends the previous one
    EXPECT_EQ(ended, 1);
    EXPECT_EQ(second.get_stop_token().stop_requested(), false);
  }
  EXPECT_EQ(ended, 2);
  int sum = 0;
  jthread([&](int a, int b) { sum = a + b; }, 2, 3).join();
  EXPECT_EQ(sum, 5);
  static_assert(!std::is_copy_constructible_v<jthread>);
}

} // namespace
