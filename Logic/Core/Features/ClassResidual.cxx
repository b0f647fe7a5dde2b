#include "Core/Features/ClassResidual.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::uint32_t ClassResidual::packed(std::uint16_t c, float share) {
  const auto rounded = static_cast<std::int16_t>(std::lround(std::clamp(share, -1.f, 1.f) * kOne));
  return c | static_cast<std::uint32_t>(std::bit_cast<std::uint16_t>(rounded)) << 16;
}

void checkResidual(const ClassResidual& r, int classes) {
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The residual of the model's features cannot be used: " + what);
  };
  if (r.voxels.size() != r.ends.size()) fail("it does not have one list per voxel.");
  if (r.empty()) {
    if (!r.entries.empty()) fail("its lists differ in size from what they say.");
    return;
  }
  checkGeometry(r.grid, "The grid of the features' residual");
  if (r.grid.voxelCount() > std::int64_t{0xffffffff} || r.voxels.back() >= r.grid.voxelCount() ||
      std::adjacent_find(r.voxels.begin(), r.voxels.end(), std::greater_equal<>()) != r.voxels.end())
    fail("its voxels do not ascend.");
  if (!std::is_sorted(r.ends.begin(), r.ends.end()) || r.ends.back() != r.entries.size())
    fail("its lists differ in size from what they say.");
  for (const std::uint32_t entry : r.entries)
    if (ClassResidual::unpacked(entry).c >= classes) fail("it names a class that does not exist.");
}

ClassResidualSampler::ClassResidualSampler(const ClassResidual& residual, const Affine3& indexToWorld)
    : residual_(residual) {
  if (residual.empty()) return;
  map_ = inverse(residual.grid.indexToWorld()) * indexToWorld;
  has_.assign(static_cast<std::size_t>((residual.grid.voxelCount() + 63) / 64), 0);
  for (const std::uint32_t v : residual.voxels)
    has_[v / 64] |= std::uint64_t{1} << (v % 64);
  before_.reserve(has_.size());
  std::uint32_t count = 0;
  for (const std::uint64_t word : has_) {
    before_.push_back(count);
    count += static_cast<std::uint32_t>(std::popcount(word));
  }
}

void ClassResidualSampler::add(const Vec3& index, std::span<const std::uint16_t> classes,
                               float* probabilities) const {
  if (has_.empty()) return;
  const Vec3 x = map_(index);
  const auto& n = residual_.grid.size;
  std::int64_t low[3], high[3];
  float part[3];
  for (int a = 0; a < 3; ++a) {
    if (!(x[a] >= -0.5 && x[a] < static_cast<double>(n[a]) - 0.5)) return;
    const double at = std::clamp(x[a], 0.0, static_cast<double>(n[a] - 1));
    low[a] = static_cast<std::int64_t>(at);
    high[a] = std::min(low[a] + 1, n[a] - 1);
    part[a] = static_cast<float>(at - static_cast<double>(low[a]));
  }
  bool changed = false;
  for (int corner = 0; corner < 8; ++corner) {
    float weight = 1;
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      const bool up = corner >> a & 1;
      weight *= up ? part[a] : 1 - part[a];
      at[a] = up ? high[a] : low[a];
    }
    if (weight == 0) continue;
    const auto voxel = static_cast<std::size_t>(at[0] + n[0] * (at[1] + n[1] * at[2]));
    const std::uint64_t word = has_[voxel / 64], bit = std::uint64_t{1} << (voxel % 64);
    if (!(word & bit)) continue;
    const auto own = before_[voxel / 64] + static_cast<std::size_t>(std::popcount(word & (bit - 1)));
    for (std::size_t e = own == 0 ? 0 : residual_.ends[own - 1]; e < residual_.ends[own]; ++e) {
      const ClassResidual::Entry entry = ClassResidual::unpacked(residual_.entries[e]);
      const auto place = std::find(classes.begin(), classes.end(), entry.c);
      if (place == classes.end()) continue;
      probabilities[place - classes.begin()] +=
          weight * static_cast<float>(entry.share) / ClassResidual::kOne;
      changed = true;
    }
  }
  if (!changed) return;
  float sum = 0;
  for (std::size_t c = 0; c < classes.size(); ++c)
    sum += probabilities[c] = std::max(probabilities[c], 0.f);
  for (std::size_t c = 0; c < classes.size() && sum > 0; ++c)
    probabilities[c] /= sum;
}

} // namespace innergs
