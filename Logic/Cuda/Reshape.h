#pragma once
#include "Core/Fit/Densify.h"
#include "Core/Fit/Relocate.h"
#include "Cuda/Buffer.h"

namespace innergs::cuda {

/// The state of a fit where an executor runs. Gaussians are stored as their 16 floats, so that one kernel
/// reorders both them and their moments.
struct FitBuffers {
  explicit FitBuffers(Executor& e) : gaussians(e), moment1(e), moment2(e), gradientSums(e) {}

  Gaussian* field() const { return reinterpret_cast<Gaussian*>(gaussians.data()); }
  /// Reserves room for at least `size`; the content is lost when it grows. All or nothing.
  void reserve(Executor& executor, std::int64_t size);

  std::int64_t count = 0;
  Buffer<float> gaussians, moment1, moment2; // 16 per Gaussian
  Buffer<float> gradientSums;
};

/// Indices of Gaussians with their keys, for sorting.
class Ranking {
public:
  explicit Ranking(Executor& e) : executor_(e), keys_(e), otherKeys_(e), ids_(e), otherIds_(e) {}

  /// The only source of Error(Memory).
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

/// relocateGaussians() on the device, without waiting for it.
class Relocation {
public:
  explicit Relocation(Executor& e)
      : executor_(e), priority_(e), influence_(e), marks_(e), counts_(e), place_(e), replaced_(e), boxes_(e) {
  }

  /// Reserves memory for that many Gaussians; the only source of Error(Memory).
  void reserve(std::int64_t count);
  void clear();
  /// spare: room for one record per Gaussian, with arbitrary content. Behind a closed guard nothing changes.
  void run(FitBuffers& fit, Buffer<float>& spare, const RelocationPlan& plan, const Guard& guard = {});

private:
  Executor& executor_;
  Ranking priority_, influence_;
  Buffer<std::uint8_t> marks_;
  Buffer<std::int64_t> counts_, place_;
  Buffer<std::uint32_t> replaced_;
  Buffer<MeanBox> boxes_;
};

/// densifyGaussians() on the device; waits twice for a number of Gaussians. On Error(Memory) nothing has
/// changed.
DensifyCounts densify(Executor& executor, FitBuffers& fit, Blending blending, int iterations,
                      const DensifyPlan& plan);

} // namespace innergs::cuda
