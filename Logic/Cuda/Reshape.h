#pragma once
#include "Core/Fit/Densify.h"
#include "Core/Fit/Relocate.h"
#include "Cuda/Executor.h"

namespace innergs::cuda {

/// What a fit holds where an executor runs. Gaussians are kept as the 16 floats that they are, so that one
/// kernel reorders them and their moments.
struct FitBuffers {
  explicit FitBuffers(Executor& e) : gaussians(e), moment1(e), moment2(e), gradientSums(e) {}

  Gaussian* field() const { return reinterpret_cast<Gaussian*>(gaussians.data()); }
  /// Room for `size` at least; what they held is lost when they grow. All or nothing.
  void reserve(Executor& executor, std::int64_t size);

  std::int64_t count = 0;
  Buffer<float> gaussians, moment1, moment2; // 16 a Gaussian
  Buffer<float> gradientSums;
};

/// Numbers of Gaussians with their keys, to be sorted.
class Ranking {
public:
  explicit Ranking(Executor& e) : executor_(e), keys_(e), otherKeys_(e), ids_(e), otherIds_(e) {}

  /// Error(Memory) comes from here alone.
  void reserve(std::int64_t count);
  void sort(std::int64_t count, int bits) {
    sortPairs(executor_, keys_, otherKeys_, ids_, otherIds_, count, bits);
  }
  void clear();
  std::uint64_t* keys() const { return keys_.data(); }
  std::uint32_t* ids() const { return ids_.data(); }

private:
  Executor& executor_;
  Buffer<std::uint64_t> keys_, otherKeys_;
  Buffer<std::uint32_t> ids_, otherIds_;
};

/// relocateGaussians() without leaving the device, and without waiting for it.
class Relocation {
public:
  explicit Relocation(Executor& e)
      : executor_(e), need_(e), use_(e), marks_(e), counts_(e), place_(e), victims_(e), boxes_(e) {}

  /// Memory for so many Gaussians; Error(Memory) comes from here alone.
  void reserve(std::int64_t count);
  void clear();
  /// spare: room for a record a Gaussian; its content does not matter. Behind a closed guard nothing changes.
  void run(FitBuffers& fit, Buffer<float>& spare, const RelocationPlan& plan, const Guard& guard = {});

private:
  Executor& executor_;
  Ranking need_, use_;
  Buffer<std::uint8_t> marks_;
  Buffer<std::int64_t> counts_, place_;
  Buffer<std::uint32_t> victims_;
  Buffer<MeanBox> boxes_;
};

/// densifyGaussians() on the device; waits for numbers of Gaussians, twice. Error(Memory) leaves all as it
/// was.
DensifyCounts densify(Executor& executor, FitBuffers& fit, Blending blending, int iterations,
                      const DensifyPlan& plan);

} // namespace innergs::cuda
