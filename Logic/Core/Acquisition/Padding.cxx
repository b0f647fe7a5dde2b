#include "Core/Acquisition/Padding.h"

#include "Core/Base/NumberText.h"
#include "Core/Image/Components.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

namespace innergs {
namespace {

using Marks = std::vector<std::uint8_t>; // per voxel
using Size = std::array<std::int64_t, 3>;

constexpr double kLeastShare = 0.01;      // of the border's voxels that have the same value
constexpr float kAir = 0.1F;              // of the range, up to which a voxel may be air
constexpr double kNearlyAll = 0.8;        // of the places around one: dark tissue is like air
constexpr double kCoarse = 3;             // mm, between these places
constexpr std::size_t kSampled = 1 << 20; // voxels that tell the range

/// Calls visit(v) for every voxel on the image's six faces; those of edges several times.
void visitBorder(const Size& n, const std::function<void(std::int64_t)>& visit) {
  const Size step{1, n[0], n[0] * n[1]};
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (const std::int64_t end : {std::int64_t{0}, n[axis] - 1})
      for (std::int64_t j = 0; j < n[b]; ++j)
        for (std::int64_t k = 0; k < n[c]; ++k)
          visit(end * step[axis] + j * step[b] + k * step[c]);
  }
}

/// The most frequent value on the border, if a fair share of it has that.
std::optional<float> borderValue(const Volume& image) {
  std::map<float, std::int64_t> counts;
  std::int64_t all = 0;
  visitBorder(image.geometry.size, [&](std::int64_t v) {
    const float value = image.voxels[static_cast<std::size_t>(v)];
    if (!std::isfinite(value)) return;
    ++all;
    ++counts[value];
  });
  if (counts.empty()) return std::nullopt;
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (static_cast<double>(most->second) < kLeastShare * static_cast<double>(all)) return std::nullopt;
  return most->first;
}

/// 1 where the image has the value from its border on.
Marks constantBorder(const Volume& image, float value, const std::stop_token& stop) {
  const Size& n = image.geometry.size;
  Marks marks(image.voxels.size());
  for (std::size_t v = 0; v < marks.size(); ++v)
    marks[v] = image.voxels[v] == value;
  visitBorder(n, [&](std::int64_t v) {
    if (marks[static_cast<std::size_t>(v)] == 1) floodFill(marks, n, v, stop);
  });
  for (std::uint8_t& mark : marks)
    mark = mark == 2;
  return marks;
}

/// Sums of marks over boxes (an integral image).
class BoxSums {
public:
  BoxSums(const Marks& marks, const Size& n) : n_(n) {
    sums_.assign(static_cast<std::size_t>((n[0] + 1) * (n[1] + 1) * (n[2] + 1)), 0);
    for (std::int64_t k = 0, v = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j) {
        std::int64_t row = 0;
        for (std::int64_t i = 0; i < n[0]; ++i, ++v) {
          row += marks[static_cast<std::size_t>(v)];
          at(i + 1, j + 1, k + 1) = row + at(i + 1, j, k + 1) + at(i + 1, j + 1, k) - at(i + 1, j, k);
        }
      }
  }

  /// The mean over the box's voxels inside the image.
  double mean(const Size& centre, const Size& reach) {
    Size low, high;
    double count = 1;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::max<std::int64_t>(0, centre[a] - reach[a]);
      high[a] = std::min(n_[a], centre[a] + reach[a] + 1);
      count *= static_cast<double>(high[a] - low[a]);
    }
    const auto below = [&](std::int64_t k) {
      return at(high[0], high[1], k) - at(low[0], high[1], k) - at(high[0], low[1], k) +
             at(low[0], low[1], k);
    };
    return static_cast<double>(below(high[2]) - below(low[2])) / count;
  }

private:
  std::int64_t& at(std::int64_t i, std::int64_t j, std::int64_t k) {
    return sums_[static_cast<std::size_t>(i + (n_[0] + 1) * (j + (n_[1] + 1) * k))];
  }

  Size n_;
  std::vector<std::int64_t> sums_;
};

/// Marks the voxels next to marked ones, too.
void dilate(Marks& marks, const Size& n) {
  const Size step{1, n[0], n[0] * n[1]};
  const Marks before = marks;
  for (std::int64_t v = 0; v < static_cast<std::int64_t>(marks.size()); ++v) {
    if (!before[static_cast<std::size_t>(v)]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t at = v / step[axis] % n[axis];
      if (at > 0) marks[static_cast<std::size_t>(v - step[axis])] = 1;
      if (at + 1 < n[axis]) marks[static_cast<std::size_t>(v + step[axis])] = 1;
    }
  }
}

/// The range of an image without its highest values.
ValueRange usualRange(const Volume& image) {
  std::vector<float> values;
  const std::size_t step = image.voxels.size() / kSampled + 1;
  for (std::size_t v = 0; v < image.voxels.size(); v += step)
    if (std::isfinite(image.voxels[v])) values.push_back(image.voxels[v]);
  if (values.empty()) return {0, 0};
  const auto high =
      values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), high, values.end());
  return {*std::min_element(values.begin(), high + 1), *high};
}

/// What one scan shows.
struct Shown {
  Marks constant;      // see constantBorder(); empty: nothing
  float air = 0;       // its border's value, or its least
  float different = 0; // from air by at least this: body
  Affine3 toWorld, toIndex;
};

class PaddingSearch {
public:
  PaddingSearch(std::span<const Stack> scans, std::span<const std::size_t> part,
                std::span<const Affine3> toWorld, ThreadPool& pool)
      : scans_(scans), part_(part), pool_(pool), shown_(scans.size()) {
    for (const std::size_t s : part) {
      const Volume& image = scans[s].image;
      Shown& shown = shown_[s];
      const ValueRange range = usualRange(image);
      const std::optional<float> border = borderValue(image);
      if (border && scans[s].poses.empty()) shown.constant = constantBorder(image, *border, pool.stopToken());
      shown.air = border.value_or(range.low);
      shown.different = kAir * (range.high - range.low);
      shown.toWorld = toWorld[s] * image.geometry.indexToWorld();
      shown.toIndex = inverse(shown.toWorld);
    }
  }

  Marks paddingOf(std::size_t scan, double margin) const {
    const Marks& constant = shown_[scan].constant;
    if (std::find(constant.begin(), constant.end(), 1) == constant.end() || !reachesInto(scan, margin))
      return {};
    Marks padded = constant;
    dilate(padded, scans_[scan].image.geometry.size);
    return elsewhere(scan, padded, {1, 1, 1}, [&](std::size_t s, std::size_t v) { return acquired(s, v); });
  }

private:
  bool acquired(std::size_t scan, std::size_t voxel) const {
    return shown_[scan].constant.empty() || !shown_[scan].constant[voxel];
  }

  /// Whether others show the body nearly everywhere within `margin` (mm) of a place in the constant border.
  bool reachesInto(std::size_t scan, double margin) const {
    const GridGeometry& g = scans_[scan].image.geometry;
    Size step, n, reach;
    for (int a = 0; a < 3; ++a) {
      step[a] = std::max<std::int64_t>(1, std::llround(kCoarse / g.spacing[a]));
      n[a] = (g.size[a] + step[a] - 1) / step[a];
      reach[a] = static_cast<std::int64_t>(std::ceil(margin / (static_cast<double>(step[a]) * g.spacing[a])));
    }
    const Marks body = elsewhere(scan, shown_[scan].constant, step, [&](std::size_t s, std::size_t v) {
      return std::abs(scans_[s].image.voxels[v] - shown_[s].air) > shown_[s].different;
    });
    BoxSums sums(body, n);
    for (std::int64_t k = 0, v = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i, ++v)
          if (body[static_cast<std::size_t>(v)] && sums.mean({i, j, k}, reach) >= kNearlyAll) return true;
    return false;
  }

  /// Of every step-th voxel of a scan: whether it is marked and another one acquired its place and, at its
  /// nearest voxel, is(scan, voxel).
  template <class Condition>
  Marks elsewhere(std::size_t scan, const Marks& marked, const Size& step, const Condition& is) const {
    const GridGeometry& g = scans_[scan].image.geometry;
    Size count;
    for (int a = 0; a < 3; ++a)
      count[a] = (g.size[a] + step[a] - 1) / step[a];
    Marks found(static_cast<std::size_t>(count[0] * count[1] * count[2]), 0);
    pool_.run(count[2], [&](std::int64_t c) {
      const std::int64_t k = c * step[2];
      for (const std::size_t s : part_) {
        if (s == scan) continue;
        const Size& n = scans_[s].image.geometry.size;
        const Affine3 map = shown_[s].toIndex * shown_[scan].toWorld;
        std::int64_t v = c * count[0] * count[1];
        for (std::int64_t j = 0; j < g.size[1]; j += step[1])
          for (std::int64_t i = 0; i < g.size[0]; i += step[0], ++v) {
            if (found[static_cast<std::size_t>(v)] ||
                !marked[static_cast<std::size_t>((k * g.size[1] + j) * g.size[0] + i)])
              continue;
            const Vec3 at = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
            std::int64_t index = 0;
            bool inside = true;
            for (int a = 2; a >= 0; --a) {
              const std::int64_t nearest = std::llround(at[a]);
              inside = inside && nearest >= 0 && nearest < n[a];
              index = index * n[a] + nearest;
            }
            if (!inside) continue;
            const auto there = static_cast<std::size_t>(index);
            found[static_cast<std::size_t>(v)] = std::isfinite(scans_[s].image.voxels[there]) && is(s, there);
          }
      }
    });
    return found;
  }

  std::span<const Stack> scans_;
  std::span<const std::size_t> part_;
  ThreadPool& pool_;
  std::vector<Shown> shown_; // of each scan that takes part
};

} // namespace

std::vector<std::vector<std::uint8_t>> paddedVoxels(std::span<const Stack> scans,
                                                    std::span<const std::size_t> part,
                                                    std::span<const Affine3> toWorld, double margin,
                                                    ThreadPool& pool) {
  std::vector<Marks> padded(scans.size());
  if (part.size() < 2) return padded;
  const PaddingSearch search(scans, part, toWorld, pool);
  for (const std::size_t s : part)
    padded[s] = search.paddingOf(s, margin);
  return padded;
}

std::string paddingSentence(const std::vector<std::uint8_t>& padded, const std::string& name) {
  const auto count = static_cast<double>(std::count(padded.begin(), padded.end(), 1));
  if (count == 0) return {};
  const double percent = 100 * count / static_cast<double>(padded.size());
  return formatted(percent < 1 ? "%.1f" : "%.0f", percent) + " % of the voxels of " + name +
         " look like padding, where other scans show the body: they were left out.";
}

} // namespace innergs
