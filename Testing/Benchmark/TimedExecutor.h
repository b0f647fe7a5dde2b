#pragma once
#include "Cuda/Executor.h"

#include <functional>
#include <map>
#include <string>
#include <typeinfo>

namespace innergs::bench {

/// Seconds that an executor takes for the queued work, including the wait.
double secondsOf(cuda::Executor& executor, const std::function<void()>& queued);
/// A type's name without its namespaces, if the compiler provides it.
std::string plainName(const std::type_info& type);

struct KernelTime {
  int launches = 0;
  double seconds = 0;
};
using Profile = std::map<std::string, KernelTime>;

template <class Base, class... Kernels>
class TimedLaunches;
template <class Base>
class TimedLaunches<Base> : public Base {
protected:
  TimedLaunches(std::unique_ptr<cuda::Executor> inner, Profile& profile)
      : inner_(std::move(inner)), profile_(profile) {}
  void time(const std::string& name, const std::function<void()>& queued) {
    KernelTime& t = profile_[name];
    t.seconds += secondsOf(*inner_, queued);
    ++t.launches;
  }
  std::unique_ptr<cuda::Executor> inner_;
  Profile& profile_;
};
template <class Base, class Kernel, class... Others>
class TimedLaunches<Base, Kernel, Others...> : public TimedLaunches<Base, Others...> {
public:
  void launch(const Kernel& kernel, std::int64_t blocks) override {
    this->time(plainName(typeid(Kernel)), [&] { this->inner_->run(kernel, blocks); });
  }

protected:
  using TimedLaunches<Base, Others...>::TimedLaunches;
};
template <class List>
struct TimedBase;
template <class... Kernels>
struct TimedBase<cuda::KernelList<Kernels...>> {
  using Type = TimedLaunches<cuda::Executor, Kernels...>;
};

/// An executor that waits for every kernel and adds up the time of each kind: a profile without a profiler.
class TimedExecutor final : public TimedBase<cuda::AllKernels>::Type {
public:
  TimedExecutor(std::unique_ptr<cuda::Executor> inner, Profile& profile)
      : TimedBase<cuda::AllKernels>::Type(std::move(inner), profile) {}

  std::string name() const override { return inner_->name(); }
  std::size_t freeBytes() override { return inner_->freeBytes(); }
  void* allocate(std::size_t bytes) override { return inner_->allocate(bytes); }
  void release(void* memory) noexcept override { inner_->release(memory); }
  void upload(void* to, const void* from, std::size_t bytes) override { inner_->upload(to, from, bytes); }
  void download(void* to, const void* from, std::size_t bytes) override { inner_->download(to, from, bytes); }
  void fill(void* memory, int byte, std::size_t bytes) override {
    time("(fill)", [&] { inner_->fill(memory, byte, bytes); });
  }
  void scan(const std::int64_t* in, std::int64_t* out, std::int64_t count) override {
    time("(scan)", [&] { inner_->scan(in, out, count); });
  }
  void prepareSort(std::int64_t count, int bits) override { inner_->prepareSort(count, bits); }
  void sort(std::uint64_t*& keys, std::uint64_t*& otherKeys, std::uint32_t*& ids, std::uint32_t*& otherIds,
            std::int64_t count, int bits) override {
    time("(sort)", [&] { inner_->sort(keys, otherKeys, ids, otherIds, count, bits); });
  }
};

} // namespace innergs::bench
