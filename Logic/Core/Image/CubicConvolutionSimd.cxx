#include "Core/Base/InstructionSets.h"
#include "Core/Image/CubicConvolutionScalar.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Core/Image/CubicConvolutionSimd.cxx"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR // it has no vectors of four floats

namespace {

constexpr int kPoints = 64; // at a time; a multiple of all numbers of lanes

enum Place : std::int32_t { kOutside, kEdge, kInner };

/// Where points of a row lie on the grid.
struct Points {
  alignas(64) std::int32_t place[kPoints];
  alignas(64) std::int32_t low[3][kPoints];
  alignas(64) float fraction[3][kPoints];
  alignas(64) float weights[3][kPoints][4]; // of the voxels −1, 0, 1 and 2
};

void locate(const Volume& volume, const Vec3& start, const Vec3& step, int first, int count, Points& points) {
  const hn::CappedTag<double, kPoints> d;
  const hn::Rebind<float, decltype(d)> f32;
  const hn::Rebind<std::int32_t, decltype(d)> i32;
  const auto rounding = hn::Set(d, kIndexRounding), half = hn::Set(d, 0.5 + kIndexRounding);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int t = 0; t < count; t += lanes) {
    const auto i = hn::Iota(d, static_cast<double>(first + t));
    auto place = hn::Set(d, static_cast<double>(kInner));
    for (int a = 0; a < 3; ++a) {
      const auto last = hn::Set(d, static_cast<double>(volume.geometry.size[a] - 1));
      const auto x = hn::MulAdd(i, hn::Set(d, step[a]), hn::Set(d, start[a]));
      const auto inside = hn::And(hn::Ge(x, hn::Neg(half)), hn::Le(x, hn::Add(last, half)));
      const auto at = hn::Min(hn::Max(hn::IfThenElseZero(inside, x), hn::Zero(d)), last);
      const auto low = hn::Floor(hn::Add(at, rounding)), above = hn::Sub(at, low);
      const auto inner = hn::And(hn::Ge(low, hn::Set(d, 1.0)), hn::Le(low, hn::Sub(last, hn::Set(d, 2.0))));
      place = hn::Min(place, hn::IfThenElseZero(inside, hn::IfThenElse(inner, hn::Set(d, double{kInner}),
                                                                       hn::Set(d, double{kEdge}))));
      hn::Store(hn::DemoteTo(i32, low), i32, points.low[a] + t);
      hn::Store(hn::DemoteTo(f32, hn::IfThenZeroElse(hn::Lt(above, rounding), above)), f32,
                points.fraction[a] + t);
    }
    hn::Store(hn::DemoteTo(i32, place), i32, points.place + t);
  }
}

void weigh(int count, float keys, Points& points) {
  const hn::CappedTag<float, kPoints> d;
  const auto one = hn::Set(d, 1.F), a = hn::Set(d, keys), a2 = hn::Set(d, keys + 2),
             a3 = hn::Set(d, keys + 3);
  const auto near = [&](auto f) HWY_ATTR { return hn::MulAdd(hn::Mul(hn::MulSub(a2, f, a3), f), f, one); };
  for (auto axis = 0; axis < 3; ++axis)
    for (int t = 0; t < count; t += static_cast<int>(hn::Lanes(d))) {
      const auto f = hn::Load(d, points.fraction[axis] + t), g = hn::Sub(one, f),
                 afg = hn::Mul(a, hn::Mul(f, g));
      hn::StoreInterleaved4(hn::Mul(afg, g), near(f), near(g), hn::Mul(afg, f), d, points.weights[axis][t]);
    }
}

/// Σ over y and z of weights · voxels, for the four voxels along x from `first` on and the given offsets.
template <class D>
HWY_INLINE hn::Vec<D> columns(D d, const float* first, const std::int64_t* ys, const std::int64_t* zs,
                              const float* y, const float* z) {
  const auto y0 = hn::Set(d, y[0]), y1 = hn::Set(d, y[1]), y2 = hn::Set(d, y[2]), y3 = hn::Set(d, y[3]);
  const auto sheet = [&](std::int64_t offset) HWY_ATTR {
    const float* line = first + offset;
    const auto a = hn::MulAdd(y1, hn::LoadU(d, line + ys[1]), hn::Mul(y0, hn::LoadU(d, line + ys[0])));
    return hn::MulAdd(y3, hn::LoadU(d, line + ys[3]), hn::MulAdd(y2, hn::LoadU(d, line + ys[2]), a));
  };
  const auto a = hn::MulAdd(hn::Set(d, z[1]), sheet(zs[1]), hn::Mul(hn::Set(d, z[0]), sheet(zs[0])));
  const auto b = hn::MulAdd(hn::Set(d, z[3]), sheet(zs[3]), hn::Mul(hn::Set(d, z[2]), sheet(zs[2])));
  return hn::Add(a, b);
}

/// columns() where edge voxels repeat. Along x, where four voxels are read at once, the weights move instead.
template <class D>
HWY_NOINLINE hn::Vec<D> columnsAtEdge(D d, const Volume& volume, const std::int32_t* low, float* x,
                                      const float* y, const float* z) {
  const auto& n = volume.geometry.size;
  const std::int64_t first = std::clamp<std::int64_t>(low[0] - 1, 0, n[0] - 4);
  std::int64_t ys[4], zs[4];
  float moved[4] = {0, 0, 0, 0};
  for (int i = 0; i < 4; ++i) {
    moved[std::clamp<std::int64_t>(low[0] - 1 + i, 0, n[0] - 1) - first] += x[i];
    ys[i] = n[0] * std::clamp<std::int64_t>(low[1] - 1 + i, 0, n[1] - 1);
    zs[i] = n[0] * n[1] * std::clamp<std::int64_t>(low[2] - 1 + i, 0, n[2] - 1);
  }
  std::copy_n(moved, 4, x);
  return columns(d, volume.voxels.data() + first, ys, zs, y, z);
}

void add(const Volume& volume, const Vec3& start, const Vec3& step, float keys, int begin, int end,
         float* row) {
  const hn::FixedTag<float, 4> d;
  const auto& n = volume.geometry.size;
  if (n[0] < 4) return scalarCubicConvolution().add(volume, start, step, keys, begin, end, row);
  const std::int64_t line = n[0], plane = n[0] * n[1];
  const std::int64_t ys[4] = {0, line, 2 * line, 3 * line}, zs[4] = {0, plane, 2 * plane, 3 * plane};
  const float* corner = volume.voxels.data() - 1 - line - plane;
  Points points;
  for (int first = begin; first < end; first += kPoints) {
    const int count = std::min(kPoints, end - first);
    locate(volume, start, step, first, count, points);
    weigh(count, keys, points);
    for (int t = 0; t < count; ++t) {
      float* x = points.weights[0][t];
      const float *y = points.weights[1][t], *z = points.weights[2][t];
      const std::int32_t low[3] = {points.low[0][t], points.low[1][t], points.low[2][t]};
      auto sums = hn::Zero(d);
      if (points.place[t] == kInner)
        sums = columns(d, corner + (low[0] + line * low[1] + plane * low[2]), ys, zs, y, z);
      else if (points.place[t] == kEdge)
        sums = columnsAtEdge(d, volume, low, x, y, z);
      hn::Store(hn::Mul(sums, hn::Load(d, x)), d, x);
    }
    for (int t = 0; t < count; ++t) {
      const float* x = points.weights[0][t];
      row[first + t] += (x[0] + x[1]) + (x[2] + x[3]);
    }
  }
}

} // namespace

CubicConvolution simdCubicConvolution() {
  return {hwy::TargetName(HWY_TARGET), add};
}

#else

CubicConvolution simdCubicConvolution() {
  return scalarCubicConvolution();
}

#endif

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace innergs {
HWY_EXPORT(simdCubicConvolution);

const std::vector<CubicConvolution>& cubicConvolutions() {
  static const std::vector<CubicConvolution> sets = [] {
    std::vector<CubicConvolution> found;
    forEachInstructionSet(hwy::SupportedAndGeneratedTargets(),
                          [&] { found.push_back(HWY_DYNAMIC_DISPATCH(simdCubicConvolution)()); });
    found.push_back(scalarCubicConvolution());
    return found;
  }();
  return sets;
}

} // namespace innergs
#endif
