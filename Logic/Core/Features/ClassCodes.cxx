#include "Core/Features/ClassCodes.h"

#include "Core/Base/Random.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr int kDraws = 96; // random vectors per choice

/// The number of blocks that contain both classes, [class][class].
std::vector<float> sharedBlocks(const ClassSupport& support, int classes) {
  std::vector<float> shared(static_cast<std::size_t>(classes) * classes, 0.f);
  std::vector<int> here;
  for (std::int64_t b = 0; b < support.blocks.voxelCount(); ++b) {
    here.clear();
    for (int c = 0; c < classes; ++c)
      if (support.has(b, c)) here.push_back(c);
    for (const int c : here)
      for (const int o : here)
        ++shared[static_cast<std::size_t>(c) * classes + o];
  }
  return shared;
}

std::vector<float> unitVector(Random& random, int channels) {
  std::vector<float> v(channels);
  double length = 0;
  for (float& x : v) { // a sum of uniform numbers is nearly normal
    double sum = -6;
    for (int n = 0; n < 12; ++n)
      sum += random.uniform();
    x = static_cast<float>(sum);
    length += sum * sum;
  }
  for (float& x : v)
    x = static_cast<float>(x / std::sqrt(std::max(length, 1e-12)));
  return v;
}

} // namespace

std::vector<float> spreadCodes(const ClassSupport& support, int classes, int channels, std::uint64_t seed) {
  const std::vector<float> shared = sharedBlocks(support, classes);
  const std::size_t size = static_cast<std::size_t>(FeatureModel::kTerms) * channels;
  std::vector<float> codes(classes * size, 0.f);
  Random random(seed);
  const auto dot = [&](const float* a, const float* b) {
    float sum = 0;
    for (int n = 0; n < channels; ++n)
      sum += a[n] * b[n];
    return sum;
  };
  for (int term = 0; term < FeatureModel::kTerms; ++term)
    for (int c = 0; c < classes; ++c) {
      float* own = codes.data() + c * size + static_cast<std::size_t>(term) * channels;
      float least = std::numeric_limits<float>::max();
      for (int draw = 0; draw < kDraws; ++draw) {
        const std::vector<float> v = unitVector(random, channels);
        float cost = 0;
        for (int o = 0; o < classes; ++o) {
          const float weight = o == c ? shared[static_cast<std::size_t>(c) * classes + c] + 1
                                      : shared[static_cast<std::size_t>(c) * classes + o];
          if (weight == 0) continue;
          for (int t = 0; t <= term; ++t) { // those not yet chosen are 0
            const float d = dot(v.data(), codes.data() + o * size + static_cast<std::size_t>(t) * channels);
            if (o != c || t < term) cost += weight * d * d;
          }
        }
        if (cost < least) {
          least = cost;
          std::copy(v.begin(), v.end(), own);
        }
      }
    }
  return codes;
}

} // namespace innergs
