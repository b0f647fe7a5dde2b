#include "Core/Base/Parallel.h"

#include "Core/Base/StopToken.h"
#include "Core/Base/ThreadPriority.h"

#include <algorithm>
#include <exception>
#include <new>
#include <system_error>

namespace innergs {

int threadCount(int asked) {
  return asked > 0 ? asked : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

ThreadPool::ThreadPool(int threads) {
  threads = threadCount(threads);
  if (startWorkers(threads - 1)) return;
  const int enough = static_cast<int>(workers_.size()) / 2; // leaves memory for the work itself
  joinWorkers();
  startWorkers(enough);
}

ThreadPool::~ThreadPool() {
  joinWorkers();
}

bool ThreadPool::startWorkers(int workers) {
  try {
    while (static_cast<int>(workers_.size()) < workers)
      workers_.emplace_back([this, low = threadPriorityLowered()] {
        if (low) lowerThreadPriority();
        work();
      });
    return true;
  } catch (const std::system_error&) {
    return false;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void ThreadPool::joinWorkers() {
  {
    std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_all();
  for (auto& thread : workers_)
    thread.join();
  workers_.clear();
  quit_ = false;
}

void ThreadPool::drain(const std::function<void(std::int64_t)>& task) {
  for (;;) {
    std::int64_t i;
    {
      std::lock_guard lock(mutex_);
      if (next_ >= count_) return;
      i = next_++;
    }
    try {
      task(i);
    } catch (...) {
      std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      next_ = count_;
    }
  }
}

void ThreadPool::work() {
  std::uint64_t seen = 0;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return quit_ || generation_ != seen; });
    if (quit_) return;
    seen = generation_;
    const auto* task = task_;
    lock.unlock();
    drain(*task);
    lock.lock();
    if (--busy_ == 0) done_.notify_one();
  }
}

void ThreadPool::throwIfStopped() const {
  innergs::throwIfStopped(stop_);
}

void ThreadPool::run(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  runToEnd(count, [&](std::int64_t i) {
    throwIfStopped();
    task(i);
  });
}

void ThreadPool::runToEnd(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  if (count <= 0) return;
  if (workers_.empty() || count == 1) {
    for (std::int64_t i = 0; i < count; ++i)
      task(i);
    return;
  }
  {
    std::lock_guard lock(mutex_);
    task_ = &task;
    next_ = 0;
    count_ = count;
    busy_ = static_cast<int>(workers_.size());
    error_ = nullptr;
    ++generation_;
  }
  wake_.notify_all();
  drain(task);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return busy_ == 0; });
  if (error_) std::rethrow_exception(error_);
}

void ThreadPool::blocks(std::int64_t count, std::int64_t block,
                        const std::function<void(std::int64_t, std::int64_t)>& task) {
  run((count + block - 1) / block,
      [&](std::int64_t i) { task(i * block, std::min(count, (i + 1) * block)); });
}

} // namespace innergs
