#include "Core/Alignment/SliceVolume.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr std::int64_t kBlock = 1 << 16;

double dotProduct(const std::vector<float>& a, const std::vector<float>& b, ThreadPool& pool) {
  const auto size = static_cast<std::int64_t>(a.size());
  std::vector<double> parts(static_cast<std::size_t>((size + kBlock - 1) / kBlock));
  pool.blocks(size, kBlock, [&](std::int64_t from, std::int64_t to) {
    double sum = 0;
    for (std::int64_t v = from; v < to; ++v)
      sum += static_cast<double>(a[v]) * b[v];
    parts[from / kBlock] = sum;
  });
  double sum = 0;
  for (const double part : parts)
    sum += part;
  return sum;
}

/// a += factor·b
void addScaled(std::vector<float>& a, double factor, const std::vector<float>& b, ThreadPool& pool) {
  const auto f = static_cast<float>(factor);
  pool.blocks(static_cast<std::int64_t>(a.size()), kBlock, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v)
      a[v] += f * b[v];
  });
}

/// out += weight · (the grid's Laplacian, negative) · volume.
void addRoughness(const std::vector<float>& volume, const std::array<std::int64_t, 3>& n, float weight,
                  std::vector<float>& out, ThreadPool& pool) {
  pool.run(n[2], [&](std::int64_t k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const auto line = [&](std::int64_t atJ, std::int64_t atK) { // beyond the faces, voxels repeat
        return volume.data() + n[0] * (std::clamp<std::int64_t>(atJ, 0, n[1] - 1) +
                                       n[1] * std::clamp<std::int64_t>(atK, 0, n[2] - 1));
      };
      const float *middle = line(j, k), *before = line(j - 1, k), *after = line(j + 1, k),
                  *below = line(j, k - 1), *above = line(j, k + 1);
      float* to = out.data() + n[0] * (j + n[1] * k);
      const auto add = [&](std::int64_t i, std::int64_t left, std::int64_t right) {
        const float v = middle[i];
        to[i] += weight * ((v - middle[left]) + (v - middle[right]) + (v - before[i]) + (v - after[i]) +
                           (v - below[i]) + (v - above[i]));
      };
      add(0, 0, std::min<std::int64_t>(1, n[0] - 1));
      for (std::int64_t i = 1; i + 1 < n[0]; ++i)
        add(i, i - 1, i + 1);
      if (n[0] > 1) add(n[0] - 1, n[0] - 2, n[0] - 1);
    }
  });
}

} // namespace

void fitVolume(std::vector<float>& volume, const SliceOperator& op,
               std::span<const PlacedSlice* const> slices, const SliceVolumePlan& plan, ThreadPool& pool) {
  const auto& n = op.grid().size;
  const auto voxels = static_cast<std::size_t>(op.grid().voxelCount());
  const auto count = static_cast<std::int64_t>(slices.size());
  std::vector<std::vector<float>> images(slices.size());
  double data = 0;
  for (const PlacedSlice* slice : slices) {
    double squares = 0;
    for (const double w : slice->profile.weight)
      squares += w * w;
    data += slice->weight * slice->gain * slice->gain * squares * static_cast<double>(slice->observed);
  }
  const auto smoothness = static_cast<float>(plan.smoothness * data / static_cast<double>(voxels));
  /// out = (AᵀWA + smoothness) x, or with a target its residual AᵀW(target − Ax) − smoothness x.
  const auto apply = [&](const std::vector<float>& x, bool residual, std::vector<float>& out) {
    pool.run(count, [&](std::int64_t s) {
      const PlacedSlice& slice = *slices[s];
      images[s] = op.project(x, slice);
      const auto gain = static_cast<float>(slice.gain), weight = static_cast<float>(slice.weight) * gain;
      for (std::size_t p = 0; p < images[s].size(); ++p) {
        float& value = images[s][p];
        value = std::isnan(value) ? 0
                : residual        ? weight * (slice.values[p] - gain * value)
                                  : weight * gain * value;
      }
    });
    std::fill(out.begin(), out.end(), 0.f);
    op.addTransposed(slices, images, out);
    addRoughness(x, n, residual ? -smoothness : smoothness, out, pool);
  };
  volume.resize(voxels, 0.f);
  std::vector<float> r(voxels), q(voxels);
  apply(volume, true, r);
  std::vector<float> p = r;
  double rr = dotProduct(r, r, pool);
  const double enough = 1e-8 * rr;
  for (int iteration = 0; iteration < plan.iterations && rr > enough; ++iteration) {
    apply(p, false, q);
    const double pq = dotProduct(p, q, pool);
    if (!(pq > 0)) break;
    const double alpha = rr / pq;
    addScaled(volume, alpha, p, pool);
    addScaled(r, -alpha, q, pool);
    const double next = dotProduct(r, r, pool);
    const auto beta = static_cast<float>(next / rr);
    pool.blocks(static_cast<std::int64_t>(voxels), kBlock, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t v = from; v < to; ++v)
        p[v] = r[v] + beta * p[v];
    });
    rr = next;
  }
}

} // namespace innergs
