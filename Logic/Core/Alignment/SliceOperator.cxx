#include "Core/Alignment/SliceOperator.h"

#include "Core/Alignment/TrilinearRows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kSlab = 4; // planes that one task owns

/// A slice's pixels and sub-planes in index coordinates of the volume.
struct Track {
  std::array<std::int64_t, 3> size; // of the volume
  float base[3], alongI[3], alongJ[3];
  std::vector<std::array<float, 3>> offset; // of the sub-planes
  std::vector<float> weight;

  Track(const PlacedSlice& slice, const GridGeometry& grid, const Affine3& worldToIndex) : size(grid.size) {
    const Affine3 map = worldToIndex * slice.pose * slice.toWorld;
    const Vec3 normal = worldToIndex.linear * (slice.pose.linear * slice.normal);
    for (int a = 0; a < 3; ++a) {
      base[a] = static_cast<float>(map.offset[a]);
      alongI[a] = static_cast<float>(map.linear[a][0]);
      alongJ[a] = static_cast<float>(map.linear[a][1]);
    }
    for (std::size_t q = 0; q < slice.profile.offset.size(); ++q) {
      auto& o = offset.emplace_back();
      for (int a = 0; a < 3; ++a)
        o[a] = static_cast<float>(slice.profile.offset[q] * normal[a]);
      weight.push_back(static_cast<float>(slice.profile.weight[q]));
    }
  }

  /// Whether any of the slice's points may lie between these places along the volume's third axis.
  bool reaches(const PlacedSlice& slice, float low, float high) const {
    float least = std::numeric_limits<float>::max(), most = -least;
    for (const int i : {0, slice.nx - 1})
      for (const int j : {0, slice.ny - 1})
        for (const auto& o : {offset.front(), offset.back()}) {
          const float z =
              base[2] + static_cast<float>(i) * alongI[2] + static_cast<float>(j) * alongJ[2] + o[2];
          least = std::min(least, z);
          most = std::max(most, z);
        }
    constexpr float kRounding = 0.01f;
    return most >= low - kRounding && least <= high + kRounding;
  }

  PointRow row(int j, std::size_t q) const {
    PointRow row{size, {}, {alongI[0], alongI[1], alongI[2]}};
    for (int a = 0; a < 3; ++a)
      row.start[a] = base[a] + static_cast<float>(j) * alongJ[a] + offset[q][a];
    return row;
  }
};

struct Box {
  float high[3];
  explicit Box(const GridGeometry& grid) {
    for (int a = 0; a < 3; ++a)
      high[a] = static_cast<float>(grid.size[a] - 1) - 1e-3f;
  }
  bool holds(const PointRow& row, float i) const {
    for (int a = 0; a < 3; ++a) {
      const float x = row.start[a] + i * row.step[a];
      if (!(x >= 0 && x <= high[a])) return false;
    }
    return true;
  }
};

} // namespace

std::vector<PlacedSlice> placedSlices(const Stack& stack, std::size_t index, int factor,
                                      const ProfileQuadrature& profile) {
  const GridGeometry& g = stack.image.geometry;
  const Affine3 map = g.indexToWorld();
  std::vector<PlacedSlice> slices;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    PlacedSlice s;
    s.stack = index;
    s.index = k;
    s.nx = static_cast<int>((g.size[0] + factor - 1) / factor);
    s.ny = static_cast<int>((g.size[1] + factor - 1) / factor);
    const double shift = 0.5 * (factor - 1);
    Affine3 coarse;
    coarse.linear = diagonal({static_cast<double>(factor), static_cast<double>(factor), 1});
    coarse.offset = {shift, shift, static_cast<double>(k)};
    s.toWorld = map * coarse;
    s.normal = column(g.direction, 2);
    if (!stack.poses.empty()) s.pose = stack.poses[static_cast<std::size_t>(k)];
    s.profile = profile;
    s.values.assign(static_cast<std::size_t>(s.nx) * s.ny, std::numeric_limits<float>::quiet_NaN());
    for (int y = 0; y < s.ny; ++y)
      for (int x = 0; x < s.nx; ++x) {
        double sum = 0;
        int n = 0;
        for (std::int64_t j = y * factor; j < std::min<std::int64_t>(g.size[1], (y + 1) * factor); ++j)
          for (std::int64_t i = x * factor; i < std::min<std::int64_t>(g.size[0], (x + 1) * factor); ++i) {
            const std::size_t v = i + g.size[0] * (j + g.size[1] * k);
            if (!isKnown(stack, v)) continue;
            sum += stack.image.voxels[v];
            ++n;
          }
        if (2 * n < factor * factor) continue;
        s.values[static_cast<std::size_t>(y) * s.nx + x] = static_cast<float>(sum / n);
        ++s.observed;
      }
    slices.push_back(std::move(s));
  }
  return slices;
}

SliceOperator::SliceOperator(const GridGeometry& grid, ThreadPool& pool)
    : grid_(grid), pool_(pool), worldToIndex_(inverse(grid.indexToWorld())) {}

std::vector<float> SliceOperator::project(const std::vector<float>& volume, const PlacedSlice& slice) const {
  const Track track(slice, grid_, worldToIndex_);
  const Box box(grid_);
  const TrilinearRows& rows = trilinearRows().front();
  const std::size_t last = track.weight.size() - 1;
  std::vector<float> out(slice.values.size());
  for (int j = 0; j < slice.ny; ++j) {
    const PointRow lowEnd = track.row(j, 0), highEnd = track.row(j, last);
    float* line = out.data() + static_cast<std::size_t>(j) * slice.nx;
    const float* given = slice.values.data() + static_cast<std::size_t>(j) * slice.nx;
    int begin = slice.nx, end = 0;
    for (int i = 0; i < slice.nx; ++i) {
      const auto x = static_cast<float>(i);
      const bool seen = !std::isnan(given[i]) && box.holds(lowEnd, x) && box.holds(highEnd, x);
      line[i] = seen ? 0 : std::numeric_limits<float>::quiet_NaN();
      if (!seen) continue;
      begin = std::min(begin, i);
      end = i + 1;
    }
    for (std::size_t q = 0; q <= last && begin < end; ++q)
      rows.read(volume.data(), track.row(j, q), track.weight[q], begin, end, line);
  }
  return out;
}

void SliceOperator::addTransposed(std::span<const PlacedSlice* const> slices,
                                  std::span<const std::vector<float>> images,
                                  std::vector<float>& volume) const {
  std::vector<Track> tracks;
  for (const PlacedSlice* slice : slices)
    tracks.emplace_back(*slice, grid_, worldToIndex_);
  const TrilinearRows& rows = trilinearRows().front();
  pool_.run((grid_.size[2] + kSlab - 1) / kSlab, [&](std::int64_t slab) {
    const std::int64_t z0 = slab * kSlab, z1 = std::min(grid_.size[2], z0 + kSlab);
    const float low = static_cast<float>(z0 - 1), high = static_cast<float>(z1); // of z that reach the slab
    for (std::size_t s = 0; s < slices.size(); ++s) {
      const PlacedSlice& slice = *slices[s];
      const Track& track = tracks[s];
      if (!track.reaches(slice, low, high)) continue;
      for (int j = 0; j < slice.ny; ++j) {
        const float* line = images[s].data() + static_cast<std::size_t>(j) * slice.nx;
        for (std::size_t q = 0; q < track.weight.size(); ++q) {
          const PointRow row = track.row(j, q);
          int from = 0, to = slice.nx;
          const float start = row.start[2], step = row.step[2];
          if (std::abs(step) < 1e-6f) {
            if (start < low || start > high) continue;
          } else {
            const float a = (low - start) / step, b = (high - start) / step;
            from = static_cast<int>(
                std::clamp(std::floor(std::min(a, b)) - 1, 0.f, static_cast<float>(slice.nx)));
            to = static_cast<int>(
                std::clamp(std::ceil(std::max(a, b)) + 2, 0.f, static_cast<float>(slice.nx)));
          }
          rows.add(line, row, track.weight[q], from, to, z0, z1, volume.data());
        }
      }
    }
  });
}

SliceOperator::Reader::Reader(const SliceOperator& op, const std::vector<float>& volume,
                              const PlacedSlice& slice, const Affine3& pose, const Vec3& centre)
    : volume_(volume.data()), size_(op.grid_.size), direction_(op.grid_.direction),
      handedness_(determinant(op.grid_.direction) < 0 ? -1 : 1), spacing_(op.grid_.spacing[0]),
      profile_(slice.profile) {
  const Affine3 map = op.worldToIndex_ * pose * slice.toWorld;
  base_ = map.offset;
  alongI_ = column(map.linear, 0);
  alongJ_ = column(map.linear, 1);
  normal_ = op.worldToIndex_.linear * (pose.linear * slice.normal);
  centre_ = op.worldToIndex_(centre);
}

bool SliceOperator::Reader::at(int i, int j, Sample& sample) const {
  const Vec3 middle = base_ + static_cast<double>(i) * alongI_ + static_cast<double>(j) * alongJ_;
  for (const double end : {profile_.offset.front(), profile_.offset.back()})
    for (int a = 0; a < 3; ++a) {
      const double x = middle[a] + end * normal_[a];
      if (!(x >= 0 && x <= static_cast<double>(size_[a] - 1) - 1e-3)) return false;
    }
  const std::int64_t dy = size_[0], dz = size_[0] * size_[1];
  double value = 0;
  Vec3 slope{}, turn{};
  for (std::size_t q = 0; q < profile_.offset.size(); ++q) {
    const Vec3 x = middle + profile_.offset[q] * normal_;
    const auto ix = static_cast<std::int64_t>(x[0]), iy = static_cast<std::int64_t>(x[1]),
               iz = static_cast<std::int64_t>(x[2]);
    const double fx = x[0] - static_cast<double>(ix), fy = x[1] - static_cast<double>(iy),
                 fz = x[2] - static_cast<double>(iz);
    const float* p = volume_ + ix + dy * iy + dz * iz;
    const double d00 = p[1] - p[0], d10 = p[dy + 1] - p[dy], d01 = p[dz + 1] - p[dz],
                 d11 = p[dz + dy + 1] - p[dz + dy];
    const double a = p[0] + fx * d00, b = p[dy] + fx * d10, c = p[dz] + fx * d01, d = p[dz + dy] + fx * d11;
    const double e = a + fy * (b - a), f = c + fy * (d - c), w = profile_.weight[q];
    const double gx = d00 + fy * (d10 - d00), hx = d01 + fy * (d11 - d01);
    const Vec3 g{w * (gx + fz * (hx - gx)), w * ((b - a) + fz * ((d - c) - (b - a))), w * (f - e)};
    value += w * (e + fz * (f - e));
    slope = slope + g;
    turn = turn + cross(x - centre_, g);
  }
  sample.value = value;
  sample.shift = (1 / spacing_) * (direction_ * slope);
  sample.turn = handedness_ * (direction_ * turn);
  return !std::isnan(value);
}

} // namespace innergs
