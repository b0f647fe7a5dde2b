#include "Core/Base/Parallel.h"
#include "Core/Base/ThreadPriority.h"
#include "ThrownError.h"

#include <atomic>
#include <gtest/gtest.h>
#include <thread>

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

using namespace innergs;

class Pool : public ::testing::TestWithParam<int> {
protected:
  ThreadPool pool{GetParam()};
};

TEST_P(Pool, RunsEveryTaskOnce) {
  EXPECT_EQ(pool.threads(), GetParam());
  for (std::int64_t count : {0, 1, 2, 7, 1000}) {
    std::vector<std::atomic<int>> calls(count);
    pool.run(count, [&](std::int64_t i) { ++calls.at(i); });
    for (const auto& n : calls)
      EXPECT_EQ(n, 1);
  }
}

TEST_P(Pool, CutsRangesIntoBlocks) {
  std::vector<std::atomic<int>> calls(103);
  std::atomic<int> blocks{0};
  pool.blocks(103, 10, [&](std::int64_t first, std::int64_t last) {
    EXPECT_EQ(first % 10, 0);
    EXPECT_LE(last - first, 10);
    for (std::int64_t i = first; i < last; ++i)
      ++calls.at(i);
    ++blocks;
  });
  EXPECT_EQ(blocks, 11);
  for (const auto& n : calls)
    EXPECT_EQ(n, 1);
}

TEST_P(Pool, RethrowsTheExceptionOfATaskAndStaysUsable) {
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> ran{0};
    EXPECT_THROW(pool.run(100000,
                          [&](std::int64_t i) {
                            ++ran;
                            if (i >= 5) throw std::runtime_error("broken");
                          }),
                 std::runtime_error);
    EXPECT_LE(ran, 5 + GetParam()) << "what was left was not abandoned";
    std::atomic<std::int64_t> sum{0};
    pool.run(100, [&](std::int64_t i) { sum += i; });
    EXPECT_EQ(sum, 4950);
  }
}

TEST_P(Pool, StopsBetweenTasks) {
  std::stop_source source;
  pool.setStop(source.get_token());
  std::atomic<int> ran{0};
  const auto stopAtTheThird = [&](std::int64_t) {
    const int order = ++ran;
    if (order == 3) source.request_stop();
    while (order > 3 && !source.stop_requested())
      std::this_thread::yield(); // the third may be held up before its request
  };
  EXPECT_EQ(test::codeOf([&] { pool.run(10000, stopAtTheThird); }), ErrorCode::Cancelled);
  EXPECT_GE(ran, 3);
  EXPECT_LE(ran, 3 + GetParam()); // those already started
  EXPECT_THROW(pool.throwIfStopped(), Error);
  std::atomic<int> all{0};
  pool.runToEnd(50, [&](std::int64_t) { ++all; });
  EXPECT_EQ(all, 50);
  pool.setStop({});
  EXPECT_NO_THROW(pool.throwIfStopped());
  EXPECT_NO_THROW(pool.run(5, [](std::int64_t) {}));
}

INSTANTIATE_TEST_SUITE_P(Threads, Pool, ::testing::Values(1, 2, 3, 8));

TEST(PoolOfAllCores, HasAtLeastOneThread) {
  EXPECT_GE(ThreadPool(0).threads(), 1);
}

#ifdef __linux__
TEST(ThreadPriority, GoesDownOnceAndDownToThePoolOfTheThread) {
  const auto niceNow = [] { return getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid))); };
  const int before = niceNow();
  if (before > 10) GTEST_SKIP() << "this process has a low priority already";
  std::atomic<int> lower{0}, tasks{0};
  std::thread([&] {
    lowerThreadPriority();
    lowerThreadPriority();
    const int own = niceNow();
    EXPECT_GT(own, before);
    ThreadPool pool(3);
    pool.run(100, [&](std::int64_t) {
      ++tasks;
      lower += niceNow() == own && threadPriorityLowered();
      std::this_thread::yield();
    });
  }).join();
  EXPECT_EQ(tasks, 100);
  EXPECT_EQ(lower, 100);
  EXPECT_EQ(niceNow(), before);
  EXPECT_FALSE(threadPriorityLowered());
}
#endif
