#include "Core/Model/ResidualSampler.h"

#include "Core/Base/InstructionSets.h"

#include <array>
#include <cmath>

namespace innergs {
namespace {

using Index = std::array<std::int64_t, 3>;

/// Whether all components are whole numbers; `whole` receives them. The numbers of voxels bound them.
bool areWhole(const Vec3& v, double tolerance, Index& whole) {
  for (int a = 0; a < 3; ++a) {
    const double nearest = std::round(v[a]);
    if (!(std::abs(v[a] - nearest) <= tolerance && std::abs(nearest) < 1e9)) return false;
    whole[a] = static_cast<std::int64_t>(nearest);
  }
  return true;
}

} // namespace

ResidualSampler::ResidualSampler(const GaussianField& field, const Affine3& indexToWorld,
                                 const std::string& instructionSet)
    : residual_(field.residual), kernels_(kernelsOf(cubicConvolutions(), instructionSet)) {
  if (!residual_.voxels.empty()) map_ = inverse(residual_.geometry.indexToWorld()) * indexToWorld;
}

void ResidualSampler::add(double y, double z, int begin, int end, float* row) const {
  if (residual_.voxels.empty() || begin >= end) return;
  const Vec3 start = map_({0, y, z}), step = column(map_.linear, 0);
  Index first, stride;
  if (!areWhole(start, 0.5 * kIndexRounding, first) || !areWhole(step, 0.5 * kIndexRounding / end, stride)) {
    kernels_.add(residual_, start, step, kKeys, begin, end, row);
    return;
  }
  const auto& n = residual_.geometry.size;
  const auto inside = [&](int x) {
    for (int a = 0; a < 3; ++a) {
      const std::int64_t at = first[a] + x * stride[a];
      if (at < 0 || at >= n[a]) return false;
    }
    return true;
  };
  while (begin < end && !inside(begin))
    ++begin;
  while (begin < end && !inside(end - 1))
    --end;
  const auto offset = [&](const Index& i) { return i[0] + n[0] * (i[1] + n[1] * i[2]); };
  const std::int64_t start0 = offset(first), stride0 = offset(stride);
  for (int x = begin; x < end; ++x)
    row[x] += residual_.voxels[static_cast<std::size_t>(start0 + x * stride0)];
}

} // namespace innergs
