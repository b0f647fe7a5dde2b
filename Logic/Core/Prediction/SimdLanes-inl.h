// The widest vectors that fill an array. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_LANES_INL_H
#undef INNERGS_SIMD_LANES_INL_H
#else
#define INNERGS_SIMD_LANES_INL_H
#endif

#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Calls run(tag) with vectors of at most 16 floats, or of 8. count: a multiple of 8.
template <typename Run>
HWY_INLINE void withLanes(std::int64_t count, const Run& run) {
  if (count % 16 == 0)
    run(hn::CappedTag<float, 16>());
  else
    run(hn::CappedTag<float, 8>());
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
