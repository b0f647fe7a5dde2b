#include "Core/Alignment/TrilinearRowsScalar.h"
#include "Core/Base/InstructionSets.h"

// The code stores vectors in members and array elements, which sizeless types do not allow.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Core/Alignment/TrilinearRowsSimd.cxx"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR

namespace {

constexpr int kPoints = 64; // at a time; a multiple of all numbers of lanes
using Float = hn::CappedTag<float, kPoints>;
using Int = hn::RebindToSigned<Float>;

bool fitsIndex(const PointRow& row) {
  return row.size[0] * row.size[1] * row.size[2] < std::numeric_limits<std::int32_t>::max();
}

/// The voxels below as many points of a row as there are lanes, and how far the points lie above them.
struct Cells {
  hn::Vec<Int> low[3];
  hn::Vec<Float> above[3];
};

HWY_INLINE Cells cellsAt(const PointRow& row, int first) {
  const Float d;
  const Int n;
  const auto i = hn::Iota(d, static_cast<float>(first));
  Cells cells;
  for (int a = 0; a < 3; ++a) {
    const auto last = hn::Set(d, static_cast<float>(row.size[a] - 1));
    const auto x = hn::MulAdd(i, hn::Set(d, row.step[a]), hn::Set(d, row.start[a]));
    const auto inside = hn::Min(hn::IfThenElseZero(hn::Ge(x, hn::Zero(d)), x), last);
    cells.low[a] = hn::Min(hn::ConvertTo(n, inside), hn::Set(n, static_cast<std::int32_t>(row.size[a] - 2)));
    cells.above[a] = hn::Sub(inside, hn::ConvertTo(d, cells.low[a]));
  }
  return cells;
}

HWY_INLINE hn::Vec<Int> indexOf(const PointRow& row, const Cells& cells) {
  const Int n;
  const auto nx = hn::Set(n, static_cast<std::int32_t>(row.size[0])),
             ny = hn::Set(n, static_cast<std::int32_t>(row.size[1]));
  return hn::Add(cells.low[0], hn::Mul(nx, hn::Add(cells.low[1], hn::Mul(ny, cells.low[2]))));
}

void read(const float* volume, const PointRow& row, float weight, int begin, int end, float* values) {
  if (!fitsIndex(row)) return scalarTrilinearRows().read(volume, row, weight, begin, end, values);
  const Float d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const std::int64_t dy = row.size[0], dz = row.size[0] * row.size[1];
  const auto w = hn::Set(d, weight);
  for (int i = begin; i < end; i += lanes) {
    const Cells cells = cellsAt(row, i);
    const auto at = indexOf(row, cells);
    const auto line = [&](std::int64_t offset) HWY_ATTR {
      const auto a = hn::GatherIndex(d, volume + offset, at), b = hn::GatherIndex(d, volume + offset + 1, at);
      return hn::MulAdd(cells.above[0], hn::Sub(b, a), a);
    };
    const auto plane = [&](std::int64_t offset) HWY_ATTR {
      const auto a = line(offset), b = line(offset + dy);
      return hn::MulAdd(cells.above[1], hn::Sub(b, a), a);
    };
    const auto a = plane(0), b = plane(dz), seen = hn::MulAdd(cells.above[2], hn::Sub(b, a), a);
    if (end - i >= lanes) {
      hn::StoreU(hn::MulAdd(w, seen, hn::LoadU(d, values + i)), d, values + i);
    } else {
      float rest[kPoints];
      hn::StoreU(hn::Mul(w, seen), d, rest);
      for (int t = 0; t < end - i; ++t)
        values[i + t] += rest[t];
    }
  }
}

void add(const float* values, const PointRow& row, float weight, int begin, int end, std::int64_t first,
         std::int64_t last, float* volume) {
  if (!fitsIndex(row)) return scalarTrilinearRows().add(values, row, weight, begin, end, first, last, volume);
  const Float d;
  const Int n;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const std::int64_t dy = row.size[0], dz = row.size[0] * row.size[1];
  const auto one = hn::Set(d, 1.F);
  alignas(64) std::int32_t at[kPoints], plane[kPoints];
  alignas(64) float share[8][kPoints]; // of the voxels around, x first
  for (int from = begin; from < end; from += kPoints) {
    const int count = std::min(kPoints, end - from);
    for (int t = 0; t < count; t += lanes) {
      const Cells cells = cellsAt(row, from + t);
      hn::Store(indexOf(row, cells), n, at + t);
      hn::Store(cells.low[2], n, plane + t);
      const auto fx = cells.above[0], fy = cells.above[1], fz = cells.above[2], gx = hn::Sub(one, fx),
                 gy = hn::Sub(one, fy), gz = hn::Sub(one, fz);
      const hn::Vec<Float> sheet[] = {hn::Mul(gy, gz), hn::Mul(fy, gz), hn::Mul(gy, fz), hn::Mul(fy, fz)};
      for (int s = 0; s < 4; ++s) {
        hn::Store(hn::Mul(gx, sheet[s]), d, share[2 * s] + t);
        hn::Store(hn::Mul(fx, sheet[s]), d, share[2 * s + 1] + t);
      }
    }
    // Neighbours add to the same voxels, so the second would wait for the first: they come in turn.
    constexpr int kTurns = 4;
    for (int turn = 0; turn < kTurns; ++turn)
      for (int t = turn; t < count; t += kTurns) {
        const float r = weight * values[from + t];
        if (r == 0) continue;
        float* p = volume + at[t];
        if (plane[t] >= first && plane[t] < last) {
          p[0] += r * share[0][t];
          p[1] += r * share[1][t];
          p[dy] += r * share[2][t];
          p[dy + 1] += r * share[3][t];
        }
        p += dz;
        if (plane[t] + 1 >= first && plane[t] + 1 < last) {
          p[0] += r * share[4][t];
          p[1] += r * share[5][t];
          p[dy] += r * share[6][t];
          p[dy + 1] += r * share[7][t];
        }
      }
  }
}

} // namespace

TrilinearRows simdTrilinearRows() {
  return {hwy::TargetName(HWY_TARGET), read, add};
}

#else

TrilinearRows simdTrilinearRows() {
  return scalarTrilinearRows();
}

#endif

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace innergs {
HWY_EXPORT(simdTrilinearRows);

const std::vector<TrilinearRows>& trilinearRows() {
  static const std::vector<TrilinearRows> sets = [] {
    std::vector<TrilinearRows> found;
    forEachInstructionSet(hwy::SupportedAndGeneratedTargets(),
                          [&] { found.push_back(HWY_DYNAMIC_DISPATCH(simdTrilinearRows)()); });
    found.push_back(scalarTrilinearRows());
    return found;
  }();
  return sets;
}

} // namespace innergs
#endif
