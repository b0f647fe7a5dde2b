#pragma once
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace innergs {

/// The number of threads asked for; 0 or less: as many as there are cores.
int threadCount(int asked);

/// A fixed pool of threads for loops whose iterations write to separate memory, so results never depend on
/// the number of threads. If the system cannot provide all threads, it continues with fewer.
class ThreadPool {
public:
  explicit ThreadPool(int threads = 0); // 0 = all cores
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// The token that run() and blocks() check before every task. Set by the owner of the job.
  void setStop(std::stop_token stop) { stop_ = std::move(stop); }

  const std::stop_token& stopToken() const { return stop_; }

  /// Throws Error(Cancelled) if a stop was requested.
  void throwIfStopped() const;

  /// Calls task(i) for every i in [0, count); the caller works too. Rethrows the first exception of a task;
  /// throws Error(Cancelled) if a stop was requested before all tasks had run.
  void run(std::int64_t count, const std::function<void(std::int64_t)>& task);

  /// Like run(), for work that must not be left half done: ignores stop requests.
  void runToEnd(std::int64_t count, const std::function<void(std::int64_t)>& task);

  /// Calls task(first, last) for consecutive blocks of [0, count), each of at most `block`.
  void blocks(std::int64_t count, std::int64_t block,
              const std::function<void(std::int64_t, std::int64_t)>& task);

private:
  bool startWorkers(int workers); // false: could not start all of them
  void joinWorkers();
  void work();
  void drain(const std::function<void(std::int64_t)>& task);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(std::int64_t)>* task_ = nullptr;
  std::int64_t next_ = 0, count_ = 0;
  int busy_ = 0;
  std::uint64_t generation_ = 0;
  bool quit_ = false;
  std::stop_token stop_;
  std::exception_ptr error_;
};

} // namespace innergs
