#include "ThreadShortage.h"
#include "Core/Base/Failure.h"
#include "Core/Base/Parallel.h"

#include <atomic>
#include <gtest/gtest.h>

using namespace innergs;
using innergs::test::ThreadShortage;

TEST(ThreadShortage, APoolGoesOnWithFewerThreads) {
  if (!ThreadShortage::known()) GTEST_SKIP() << "this system's threads cannot be refused here";
  for (const auto& [allowed, expected] : {std::pair{0, 1}, {1, 1}, {2, 2}, {7, 4}, {100, 51}}) {
    const ThreadShortage shortage(allowed);
    ThreadPool pool(1000);
    EXPECT_EQ(pool.threads(), expected) << "half of what could be had";
    std::atomic<std::int64_t> sum{0};
    pool.run(1000, [&](std::int64_t i) { sum += i; });
    EXPECT_EQ(sum, 499500);
  }
}

TEST(ThreadShortage, IsToldInASentence) {
  if (!ThreadShortage::known()) GTEST_SKIP() << "this system's threads cannot be refused here";
  const ThreadShortage shortage(0);
  EXPECT_EQ(sentenceOf([] { std::thread([] {}).join(); }),
            "The system could not start another thread: close other programs or choose fewer threads, and "
            "try again.");
}
