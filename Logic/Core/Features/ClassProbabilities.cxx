#include "Core/Features/ClassProbabilities.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Image/Components.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr float kLeastProbability = 1 / 1024.f; // a class less likely than this is not kept
constexpr std::uint16_t kLikeliest = 0x8000, kOne = 0x7fff;

struct Entry {
  std::uint32_t voxel;
  std::uint16_t c, share;
};

void checkOptions(const SegmentOptions& o) {
  const auto refuse = [](const char* sentence) { throw Error(ErrorCode::InvalidArgument, sentence); };
  if (!(o.threshold >= 0 && o.threshold <= 1)) refuse("A segment's threshold lies between 0 and 1.");
  if (!(o.smoothing >= 0 && o.smoothing <= 100))
    refuse("A segment is smoothed with a standard deviation of 0 to 100 mm.");
  if (!(o.minimumSize >= 0 && o.minimumSize <= 1e12))
    refuse("The minimum size of a segment's parts is a volume in mm3, 0 or more.");
}

/// Along one axis with a Gaussian of `sigma` voxels, the border repeated.
void smoothAlong(std::vector<float>& values, const std::array<std::int64_t, 3>& size, int axis,
                 double sigma) {
  const auto reach = static_cast<std::int64_t>(std::ceil(3 * sigma));
  if (reach < 1) return;
  std::vector<float> weights(static_cast<std::size_t>(reach) + 1);
  float sum = 0;
  for (std::int64_t d = 0; d <= reach; ++d) {
    const double x = static_cast<double>(d) / sigma;
    weights[static_cast<std::size_t>(d)] = static_cast<float>(std::exp(-0.5 * x * x));
    sum += (d == 0 ? 1.f : 2.f) * weights[static_cast<std::size_t>(d)];
  }
  for (float& w : weights)
    w /= sum;
  const std::int64_t n = size[axis];
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
  std::vector<float> line(static_cast<std::size_t>(n + 2 * reach));
  const std::int64_t lines = size[0] * size[1] * size[2] / n;
  for (std::int64_t l = 0; l < lines; ++l) {
    float* first = values.data() + l % stride + l / stride * stride * n;
    for (std::int64_t i = 0; i < n + 2 * reach; ++i)
      line[static_cast<std::size_t>(i)] = first[stride * std::clamp<std::int64_t>(i - reach, 0, n - 1)];
    for (std::int64_t i = 0; i < n; ++i) {
      const float* at = line.data() + i + reach;
      float value = weights[0] * at[0];
      for (std::int64_t d = 1; d <= reach; ++d)
        value += weights[static_cast<std::size_t>(d)] * (at[-d] + at[d]);
      first[stride * i] = value;
    }
  }
}

} // namespace

ClassProbabilities::ClassProbabilities(const GaussianField& field, const FeatureModel& features,
                                       const GridGeometry& geometry, const FeatureQueryOptions& options)
    : geometry_(geometry), lists_(static_cast<std::size_t>(features.classes())) {
  checkGeometry(geometry, "The output grid");
  const std::int64_t available = availableMemory();
  if (geometry.voxelCount() > std::int64_t{0xffffffff} ||
      (available > 0 && geometry.voxelCount() > available / 8)) // bytes for the classes of a voxel
    throw Error(
        ErrorCode::Memory,
        "The segments do not fit into memory on this grid: choose a coarser spacing or a smaller one.");
  const auto& n = geometry.size;
  std::vector<std::vector<Entry>> rows(static_cast<std::size_t>(n[1] * n[2])); // filled for a chunk at a time
  const auto visit = [&](std::int64_t voxel, std::span<const std::uint16_t> classes, const float* p) {
    const auto best =
        static_cast<std::size_t>(std::max_element(p, p + static_cast<std::ptrdiff_t>(classes.size())) - p);
    std::vector<Entry>& row = rows[static_cast<std::size_t>(voxel / n[0])];
    for (std::size_t c = 0; c < classes.size(); ++c) {
      if (classes[c] == 0 || (p[c] < kLeastProbability && c != best)) continue;
      const auto share = static_cast<std::uint16_t>(std::lround(std::min(p[c], 1.f) * kOne));
      row.push_back({static_cast<std::uint32_t>(voxel), classes[c],
                     static_cast<std::uint16_t>(share | (c == best ? kLikeliest : 0))});
    }
  };
  const auto collect = [&](std::int64_t firstPlane, std::int64_t lastPlane) {
    for (std::int64_t r = firstPlane * n[1]; r < lastPlane * n[1]; ++r) {
      std::vector<Entry>& row = rows[static_cast<std::size_t>(r)];
      const std::int64_t j = r % n[1], k = r / n[1];
      for (const Entry& e : row) {
        List& list = lists_[e.c];
        const std::array<std::int64_t, 3> at{static_cast<std::int64_t>(e.voxel) - r * n[0], j, k};
        if (list.voxels.empty()) list.low = list.high = at;
        for (int a = 0; a < 3; ++a) {
          list.low[a] = std::min(list.low[a], at[a]);
          list.high[a] = std::max(list.high[a], at[a]);
        }
        list.voxels.push_back(e.voxel);
        list.shares.push_back(e.share);
        list.likeliest += (e.share & kLikeliest) != 0;
      }
      row = {};
    }
  };
  decodeGrid(field, features, geometry, options, visit, collect);
  for (List& list : lists_) {
    list.voxels.shrink_to_fit();
    list.shares.shrink_to_fit();
  }
}

std::int64_t ClassProbabilities::bytes() const {
  std::int64_t sum = 0;
  for (const List& list : lists_)
    sum += static_cast<std::int64_t>(list.voxels.size() * (sizeof(std::uint32_t) + sizeof(std::uint16_t)));
  return sum;
}

Segment ClassProbabilities::segment(std::span<const int> classes, const SegmentOptions& options,
                                    const std::stop_token& stop) const {
  checkOptions(options);
  Segment segment;
  segment.geometry = geometry_;
  segment.geometry.size = {0, 0, 0};
  std::array<std::int64_t, 3> low = geometry_.size, high{-1, -1, -1};
  for (const int c : classes) {
    if (c < 1 || c >= static_cast<int>(lists_.size()))
      throw Error(ErrorCode::InvalidArgument, "The model has no such segment: choose one of its own.");
    const List& list = lists_[static_cast<std::size_t>(c)];
    for (int a = 0; a < 3 && !list.voxels.empty(); ++a) {
      low[a] = std::min(low[a], list.low[a]);
      high[a] = std::max(high[a], list.high[a]);
    }
  }
  if (high[0] < 0) return segment;
  std::array<std::int64_t, 3> size;
  for (int a = 0; a < 3; ++a) {
    const auto margin = static_cast<std::int64_t>(std::ceil(3 * options.smoothing / geometry_.spacing[a]));
    low[a] = std::max<std::int64_t>(0, low[a] - margin);
    high[a] = std::min(geometry_.size[a] - 1, high[a] + margin);
    size[a] = high[a] - low[a] + 1;
  }
  segment.first = low;
  segment.geometry = cropped(geometry_, low, size);
  const auto count = static_cast<std::size_t>(segment.geometry.voxelCount());
  segment.probability.assign(count, 0.f);
  segment.mask.assign(count, 0);
  for (const int c : classes) {
    const List& list = lists_[static_cast<std::size_t>(c)];
    // Ascending voxels: the row changes seldom.
    std::int64_t row = -1, into = 0;
    for (std::size_t n = 0; n < list.voxels.size(); ++n) {
      const std::int64_t voxel = list.voxels[n], r = voxel / geometry_.size[0];
      if (r != row) {
        row = r;
        const std::int64_t j = r % geometry_.size[1] - low[1], k = r / geometry_.size[1] - low[2];
        into = size[0] * (j + size[1] * k) - r * geometry_.size[0] - low[0];
      }
      const auto at = static_cast<std::size_t>(into + voxel);
      segment.probability[at] += static_cast<float>(list.shares[n] & kOne) / kOne;
      if (list.shares[n] & kLikeliest) segment.mask[at] = 1;
    }
  }
  if (options.threshold > 0 || options.smoothing > 0) {
    std::vector<float> values;
    if (options.threshold > 0)
      values = segment.probability;
    else
      values.assign(segment.mask.begin(), segment.mask.end());
    for (int a = 0; a < 3; ++a) {
      throwIfStopped(stop);
      smoothAlong(values, size, a, options.smoothing / geometry_.spacing[a]);
    }
    const float least = options.threshold > 0 ? static_cast<float>(options.threshold) : 0.5f;
    for (std::size_t v = 0; v < count; ++v)
      segment.mask[v] = values[v] >= least;
  }
  const Vec3& mm = geometry_.spacing;
  const auto least = static_cast<std::int64_t>(std::ceil(options.minimumSize / (mm[0] * mm[1] * mm[2])));
  if (options.largestOnly || least > 1) keepParts(segment.mask, size, least, options.largestOnly, stop);
  segment.voxels = std::count(segment.mask.begin(), segment.mask.end(), 1);
  return segment;
}

} // namespace innergs
