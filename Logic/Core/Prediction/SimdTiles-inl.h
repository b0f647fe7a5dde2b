// The transforms of Winograd's convolution F(4, 3). Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_TILES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_TILES_INL_H
#undef INNERGS_SIMD_TILES_INL_H
#else
#define INNERGS_SIMD_TILES_INL_H
#endif

#include "Core/Prediction/MatrixKernels.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Calls run(first column, point 0, channel) for every vector of channels of every tile.
template <typename Image, typename Run>
HWY_INLINE void forTiles(const ImageTiles& tiles, Image* columns, const Run& run) {
  const hn::CappedTag<float, 16> d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  for (std::int64_t t = 0; t < tiles.count; ++t)
    for (int c = 0; c < tiles.channels; c += lanes)
      run(columns + t * ImageTiles::width * tiles.channels + c, t * tiles.channels + c, c);
}

void inputToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  const hn::CappedTag<float, 16> d;
  const auto two = hn::Set(d, 2.f), four = hn::Set(d, 4.f), five = hn::Set(d, 5.f);
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](const float* in, std::int64_t at, int) HWY_ATTR {
    float* out = points + at;
    const auto d0 = hn::LoadU(d, in), d1 = hn::LoadU(d, in + n), d2 = hn::LoadU(d, in + 2 * n),
               d3 = hn::LoadU(d, in + 3 * n), d4 = hn::LoadU(d, in + 4 * n), d5 = hn::LoadU(d, in + 5 * n);
    const auto even = hn::NegMulAdd(four, d2, d4), odd = hn::NegMulAdd(four, d1, d3);
    const auto evenHalf = hn::Sub(d4, d2), oddHalf = hn::Mul(two, hn::Sub(d3, d1));
    hn::StoreU(hn::MulAdd(four, d0, hn::NegMulAdd(five, d2, d4)), d, out);
    hn::StoreU(hn::Add(even, odd), d, out + step);
    hn::StoreU(hn::Sub(even, odd), d, out + 2 * step);
    hn::StoreU(hn::Add(evenHalf, oddHalf), d, out + 3 * step);
    hn::StoreU(hn::Sub(evenHalf, oddHalf), d, out + 4 * step);
    hn::StoreU(hn::MulAdd(four, d1, hn::NegMulAdd(five, d3, d5)), d, out + 5 * step);
  });
}

void outputOfPoints(const ImageTiles& tiles, const float* points, const float* biases, float leak,
                    float* columns) {
  const hn::CappedTag<float, 16> d;
  const auto two = hn::Set(d, 2.f), four = hn::Set(d, 4.f), eight = hn::Set(d, 8.f), slope = hn::Set(d, leak);
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](float* out, std::int64_t at, int channel) HWY_ATTR {
    const float* in = points + at;
    const auto m0 = hn::LoadU(d, in), m1 = hn::LoadU(d, in + step), m2 = hn::LoadU(d, in + 2 * step),
               m3 = hn::LoadU(d, in + 3 * step), m4 = hn::LoadU(d, in + 4 * step),
               m5 = hn::LoadU(d, in + 5 * step), bias = hn::LoadU(d, biases + channel);
    const auto even = hn::Add(m1, m2), odd = hn::Sub(m1, m2), even2 = hn::Add(m3, m4), odd2 = hn::Sub(m3, m4);
    const auto store = [&](auto sum, int column) HWY_ATTR {
      sum = hn::Add(sum, bias);
      hn::StoreU(hn::Max(sum, hn::Mul(slope, sum)), d, out + column * n);
    };
    store(hn::Add(m0, hn::Add(even, even2)), 0);
    store(hn::MulAdd(two, odd2, odd), 1);
    store(hn::MulAdd(four, even2, even), 2);
    store(hn::Add(m5, hn::MulAdd(eight, odd2, odd)), 3);
  });
}

void gradientToPoints(const ImageTiles& tiles, const float* columns, float* points) {
  const hn::CappedTag<float, 16> d;
  const auto two = hn::Set(d, 2.f), four = hn::Set(d, 4.f);
  const std::int64_t n = tiles.channels, step = tiles.pointStep;
  forTiles(tiles, columns, [&](const float* in, std::int64_t at, int) HWY_ATTR {
    float* out = points + at;
    const auto g0 = hn::LoadU(d, in), g1 = hn::LoadU(d, in + n), g2 = hn::LoadU(d, in + 2 * n),
               g3 = hn::LoadU(d, in + 3 * n);
    const auto even = hn::Add(g0, g2), odd = hn::Add(g1, g3), even2 = hn::MulAdd(four, g2, g0),
               odd2 = hn::Mul(two, hn::MulAdd(four, g3, g1));
    hn::StoreU(g0, d, out);
    hn::StoreU(hn::Add(even, odd), d, out + step);
    hn::StoreU(hn::Sub(even, odd), d, out + 2 * step);
    hn::StoreU(hn::Add(even2, odd2), d, out + 3 * step);
    hn::StoreU(hn::Sub(even2, odd2), d, out + 4 * step);
    hn::StoreU(g3, d, out + 5 * step);
  });
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
