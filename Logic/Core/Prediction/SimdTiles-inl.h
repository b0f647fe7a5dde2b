// The transforms of Winograd's convolution F(6, 3). Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_TILES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_TILES_INL_H
#undef INNERGS_SIMD_TILES_INL_H
#else
#define INNERGS_SIMD_TILES_INL_H
#endif

#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/SimdLanes-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Calls run(tag, first column, point 0, channel) for every vector of channels of every tile.
template <typename Image, typename Run>
HWY_INLINE void forTiles(const ImageTiles& tiles, Image* columns, const Run& run) {
  withLanes(tiles.channels, [&](auto d) HWY_ATTR {
    const auto lanes = static_cast<int>(hn::Lanes(d));
    for (std::int64_t t = 0; t < tiles.count; ++t)
      for (int c = 0; c < tiles.channels; c += lanes)
        run(d, columns + t * ImageTiles::width * tiles.channels + c, t * tiles.channels + c, c);
  });
}

void inputToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](auto d, const float* in, std::int64_t at, int) HWY_ATTR {
    float* out = points + at;
    const auto times = [&](float factor) HWY_ATTR { return hn::Set(d, factor); };
    const auto d0 = hn::LoadU(d, in), d1 = hn::LoadU(d, in + n), d2 = hn::LoadU(d, in + 2 * n),
               d3 = hn::LoadU(d, in + 3 * n), d4 = hn::LoadU(d, in + 4 * n), d5 = hn::LoadU(d, in + 5 * n),
               d6 = hn::LoadU(d, in + 6 * n), d7 = hn::LoadU(d, in + 7 * n);
    hn::StoreU(hn::MulAdd(times(5.25f), hn::Sub(d4, d2), hn::Sub(d0, d6)), d, out);
    hn::StoreU(hn::MulAdd(times(5.25f), hn::Sub(d3, d5), hn::Sub(d7, d1)), d, out + 7 * step);
    const auto pair = [&](auto even, auto odd, int point) HWY_ATTR {
      hn::StoreU(hn::Add(even, odd), d, out + point * step);
      hn::StoreU(hn::Sub(even, odd), d, out + (point + 1) * step);
    };
    pair(hn::NegMulAdd(times(4.25f), d4, hn::Add(d2, d6)), hn::NegMulAdd(times(4.25f), d3, hn::Add(d1, d5)),
         1);
    pair(hn::MulAdd(times(0.25f), d2, hn::NegMulAdd(times(1.25f), d4, d6)),
         hn::MulAdd(times(0.5f), d1, hn::NegMulAdd(times(2.5f), d3, hn::Add(d5, d5))), 3);
    pair(hn::MulAdd(times(4), d2, hn::NegMulAdd(times(5), d4, d6)),
         hn::MulAdd(times(0.5f), d5, hn::NegMulAdd(times(2.5f), d3, hn::Add(d1, d1))), 5);
  });
}

void outputOfPoints(const ImageTiles& tiles, const float* points, const float* biases, float leak,
                    float* columns) {
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](auto d, float* out, std::int64_t at, int channel) HWY_ATTR {
    const float* in = points + at;
    const auto load = [&](int point) HWY_ATTR { return hn::LoadU(d, in + point * step); };
    const auto times = [&](float factor) HWY_ATTR { return hn::Set(d, factor); };
    const auto m1 = load(1), m2 = load(2), m3 = load(3), m4 = load(4), m5 = load(5), m6 = load(6),
               bias = hn::LoadU(d, biases + channel);
    const auto even = hn::Add(m1, m2), odd = hn::Sub(m1, m2), even2 = hn::Add(m3, m4), odd2 = hn::Sub(m3, m4),
               evenHalf = hn::Add(m5, m6), oddHalf = hn::Sub(m5, m6);
    const auto store = [&](auto sum, int column) HWY_ATTR {
      sum = hn::Add(sum, bias);
      hn::StoreU(hn::Max(sum, hn::Mul(times(leak), sum)), d, out + column * n);
    };
    store(hn::Add(hn::Add(load(0), even), hn::Add(even2, evenHalf)), 0);
    store(hn::MulAdd(times(2), odd2, hn::MulAdd(times(1.f / 2), oddHalf, odd)), 1);
    store(hn::MulAdd(times(4), even2, hn::MulAdd(times(1.f / 4), evenHalf, even)), 2);
    store(hn::MulAdd(times(8), odd2, hn::MulAdd(times(1.f / 8), oddHalf, odd)), 3);
    store(hn::MulAdd(times(16), even2, hn::MulAdd(times(1.f / 16), evenHalf, even)), 4);
    store(hn::Add(load(7), hn::MulAdd(times(32), odd2, hn::MulAdd(times(1.f / 32), oddHalf, odd))), 5);
  });
}

void gradientToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](auto d, const float* in, std::int64_t at, int) HWY_ATTR {
    float* out = points + at;
    const auto times = [&](float factor) HWY_ATTR { return hn::Set(d, factor); };
    const auto g0 = hn::LoadU(d, in), g1 = hn::LoadU(d, in + n), g2 = hn::LoadU(d, in + 2 * n),
               g3 = hn::LoadU(d, in + 3 * n), g4 = hn::LoadU(d, in + 4 * n), g5 = hn::LoadU(d, in + 5 * n);
    const auto pair = [&](float x, int point) HWY_ATTR { // at ±x
      const auto square = times(x * x);
      const auto even = hn::MulAdd(square, hn::MulAdd(square, g4, g2), g0);
      const auto odd = hn::Mul(times(x), hn::MulAdd(square, hn::MulAdd(square, g5, g3), g1));
      hn::StoreU(hn::Add(even, odd), d, out + point * step);
      hn::StoreU(hn::Sub(even, odd), d, out + (point + 1) * step);
    };
    hn::StoreU(g0, d, out);
    pair(1, 1);
    pair(2, 3);
    pair(0.5f, 5);
    hn::StoreU(g5, d, out + 7 * step);
  });
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
