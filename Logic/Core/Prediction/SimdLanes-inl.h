// The widest vectors that fill an array. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_LANES_INL_H
#undef INNERGS_SIMD_LANES_INL_H
#else
#define INNERGS_SIMD_LANES_INL_H
#endif

#include <cstdint>
#include <hwy/highway.h>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Calls run(tag) with vectors of at most 16 floats, or of 8. count: a multiple of 8.
template <typename Run>
HWY_INLINE void withLanes(std::int64_t count, const Run& run) {
  using Wide = hn::CappedTag<float, 16>;
  using Narrow = hn::CappedTag<float, 8>;
  if constexpr (!std::is_same_v<Wide, Narrow>)
    if (count % 16 != 0) return run(Narrow());
  run(Wide());
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
