#include "Evaluation/LabelInterpolation.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace innergs {
namespace {

std::vector<std::int64_t> labelledSlices(const Labelmap& labels) {
  std::vector<std::int64_t> slices;
  for (std::int64_t k = 0; k < labels.geometry.size[2]; ++k)
    if (labels.isLabelled(k)) slices.push_back(k);
  if (slices.empty()) throw Error(ErrorCode::NoData, "No slice is labelled; label at least one.");
  return slices;
}

/// The nearest labelled slices on both sides; the same one twice beyond the last.
std::pair<std::int64_t, std::int64_t> neighbours(const std::vector<std::int64_t>& slices, std::int64_t k) {
  const auto above = std::lower_bound(slices.begin(), slices.end(), k);
  if (above == slices.end()) return {slices.back(), slices.back()};
  if (*above == k || above == slices.begin()) return {*above, *above};
  return {*(above - 1), *above};
}

/// Squared distances to the nearest 0 along a line of samples `step` apart (Felzenszwalb & Huttenlocher
/// 2012).
void distancesAlong(const std::vector<double>& f, double step, std::vector<double>& out) {
  const auto n = static_cast<int>(f.size());
  std::vector<int> v(f.size());
  std::vector<double> z(f.size() + 1);
  int k = -1;
  for (int q = 0; q < n; ++q) {
    if (f[q] == INFINITY) continue;
    double s = -INFINITY;
    while (k >= 0) {
      const int p = v[k];
      s = ((f[q] + step * step * q * q) - (f[p] + step * step * p * p)) / (2 * step * step * (q - p));
      if (s > z[k]) break;
      --k;
    }
    v[++k] = q;
    z[k] = k == 0 ? -INFINITY : s;
    z[k + 1] = INFINITY;
  }
  out.assign(f.size(), INFINITY);
  if (k < 0) return;
  for (int q = 0, at = 0; q < n; ++q) {
    while (z[at + 1] < q)
      ++at;
    out[q] = step * step * (q - v[at]) * (q - v[at]) + f[v[at]];
  }
}

/// Distances (mm) of a slice's pixels to the nearest pixel that is in the label (`inside`) or is not.
std::vector<float> distances(const Labelmap& labels, std::int64_t k, std::uint16_t label, bool inside) {
  const std::int64_t nx = labels.geometry.size[0], ny = labels.geometry.size[1];
  std::vector<double> squared(static_cast<std::size_t>(nx * ny)), line, out;
  for (std::int64_t j = 0; j < ny; ++j) {
    line.assign(static_cast<std::size_t>(nx), INFINITY);
    for (std::int64_t i = 0; i < nx; ++i)
      if ((labels.voxels[static_cast<std::size_t>(i + nx * (j + ny * k))] == label) == inside) line[i] = 0;
    distancesAlong(line, labels.geometry.spacing[0], out);
    std::copy(out.begin(), out.end(), squared.begin() + j * nx);
  }
  std::vector<float> result(squared.size());
  for (std::int64_t i = 0; i < nx; ++i) {
    line.resize(static_cast<std::size_t>(ny));
    for (std::int64_t j = 0; j < ny; ++j)
      line[j] = squared[static_cast<std::size_t>(i + nx * j)];
    distancesAlong(line, labels.geometry.spacing[1], out);
    for (std::int64_t j = 0; j < ny; ++j)
      result[static_cast<std::size_t>(i + nx * j)] =
          static_cast<float>(std::min(1e4, std::sqrt(out[j]))); // limit, for a label that fills the slice
  }
  return result;
}

/// Positive inside. Empty if the slice does not contain the label.
std::vector<float> signedDistance(const Labelmap& labels, std::int64_t k, std::uint16_t label) {
  const std::int64_t plane = labels.geometry.size[0] * labels.geometry.size[1];
  const auto first = labels.voxels.begin() + k * plane;
  if (std::find(first, first + plane, label) == first + plane) return {};
  std::vector<float> inner = distances(labels, k, label, false), outer = distances(labels, k, label, true);
  for (std::size_t n = 0; n < inner.size(); ++n)
    inner[n] -= outer[n];
  return inner;
}

/// A label that is absent from one slice ends halfway: its distance there is the negative of its middle's in
/// the other slice.
void endHalfway(std::vector<float>& missing, const std::vector<float>& other) {
  if (missing.empty()) missing.assign(other.size(), -*std::max_element(other.begin(), other.end()));
}

} // namespace

Labelmap nearestLabelledSlice(const Labelmap& labels) {
  const auto slices = labelledSlices(labels);
  Labelmap out = labels;
  const std::int64_t plane = labels.geometry.size[0] * labels.geometry.size[1];
  for (std::int64_t k = 0; k < labels.geometry.size[2]; ++k) {
    const auto [below, above] = neighbours(slices, k);
    const std::int64_t from = std::abs(k - below) <= std::abs(above - k) ? below : above;
    std::copy_n(labels.voxels.begin() + from * plane, plane, out.voxels.begin() + k * plane);
  }
  return out;
}

Labelmap shapeBasedInterpolation(const Labelmap& labels) {
  const auto slices = labelledSlices(labels);
  Labelmap out = labels;
  const std::int64_t plane = labels.geometry.size[0] * labels.geometry.size[1];
  using Distances = std::map<std::uint16_t, std::vector<float>>; // by label
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const std::int64_t first = slices[n], last = n + 1 < slices.size() ? slices[n + 1] : first;
    const std::int64_t begin = n == 0 ? 0 : first;
    const std::int64_t end = n + 1 < slices.size() ? last : labels.geometry.size[2];
    Distances below, above;
    for (const std::int64_t k : {first, last})
      for (std::int64_t v = 0; v < plane; ++v)
        below.try_emplace(labels.voxels[static_cast<std::size_t>(k * plane + v)]);
    for (auto& [label, values] : below) {
      values = signedDistance(labels, first, label);
      above[label] = signedDistance(labels, last, label);
      endHalfway(values, above[label]);
      endHalfway(above[label], values);
    }
    for (std::int64_t k = begin; k < end; ++k) {
      if (labels.isLabelled(k)) continue;
      const float t =
          last == first
              ? 0.f
              : std::clamp(static_cast<float>(k - first) / static_cast<float>(last - first), 0.f, 1.f);
      for (std::int64_t v = 0; v < plane; ++v) {
        float best = -std::numeric_limits<float>::max();
        for (const auto& [label, values] : below) {
          const float d =
              (1 - t) * values[static_cast<std::size_t>(v)] + t * above[label][static_cast<std::size_t>(v)];
          if (d <= best) continue;
          best = d;
          out.voxels[static_cast<std::size_t>(k * plane + v)] = label;
        }
      }
    }
  }
  return out;
}

double LabelAgreement::dice(std::size_t label) const {
  const auto sum = static_cast<double>(tested[label] + truth[label]);
  return sum > 0 ? 2 * static_cast<double>(common[label]) / sum : 1;
}

double LabelAgreement::iou(std::size_t label) const {
  const auto sum = static_cast<double>(tested[label] + truth[label] - common[label]);
  return sum > 0 ? static_cast<double>(common[label]) / sum : 1;
}

LabelAgreement agreement(const Labelmap& tested, const Labelmap& truth,
                         const std::vector<std::uint8_t>& slices) {
  if (tested.geometry.size != truth.geometry.size || tested.voxels.size() != truth.voxels.size())
    throw Error(ErrorCode::InvalidArgument,
                "Labelmaps on two grids cannot be compared; resample one of them.");
  std::size_t most = 0;
  for (const Labelmap* map : {&tested, &truth})
    for (const std::uint16_t label : map->voxels)
      most = std::max<std::size_t>(most, label);
  LabelAgreement a;
  for (auto* counts : {&a.tested, &a.truth, &a.common, &a.whole})
    counts->assign(most + 1, 0);
  const std::size_t plane = static_cast<std::size_t>(truth.geometry.size[0] * truth.geometry.size[1]);
  std::int64_t same = 0, all = 0;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v) {
    ++a.whole[truth.voxels[v]];
    if (!slices.empty() && !slices[v / plane]) continue;
    ++a.tested[tested.voxels[v]];
    ++a.truth[truth.voxels[v]];
    ++all;
    if (tested.voxels[v] != truth.voxels[v]) continue;
    ++a.common[truth.voxels[v]];
    ++same;
  }
  a.pixelAccuracy = all > 0 ? static_cast<double>(same) / static_cast<double>(all) : 1;
  return a;
}

} // namespace innergs
