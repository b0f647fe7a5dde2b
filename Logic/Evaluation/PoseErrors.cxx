#include "Evaluation/PoseErrors.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Base/Cholesky.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

struct Pair {
  Vec3 truth, found; // of one pixel, LPS mm
};

struct SlicePairs {
  Affine3 truth, found;
  std::vector<Pair> pairs;
};

bool inside(const Mask& mask, const Affine3& worldToIndex, const Vec3& x) {
  const Vec3 index = worldToIndex(x);
  std::int64_t at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = std::llround(index[a]);
    if (at[a] < 0 || at[a] >= mask.geometry.size[a]) return false;
  }
  return mask.voxels[static_cast<std::size_t>(at[0] + mask.geometry.size[0] *
                                                          (at[1] + mask.geometry.size[1] * at[2]))] != 0;
}

/// The rigid transform that brings the true places nearest to the found ones, by least squares.
Affine3 commonTransform(const std::vector<SlicePairs>& slices) {
  Affine3 common;
  Vec3 centre{};
  std::int64_t count = 0;
  for (const SlicePairs& slice : slices)
    for (const Pair& p : slice.pairs) {
      centre = centre + p.truth;
      ++count;
    }
  if (count == 0) return common;
  centre = (1 / static_cast<double>(count)) * centre;
  for (int step = 0; step < 10; ++step) {
    std::vector<double> square(36), right(6);
    for (const SlicePairs& slice : slices)
      for (const Pair& p : slice.pairs) {
        const Vec3 x = common(p.truth), d = p.found - x, arm = x - centre;
        const double j[3][6] = {
            {1, 0, 0, 0, arm[2], -arm[1]}, {0, 1, 0, -arm[2], 0, arm[0]}, {0, 0, 1, arm[1], -arm[0], 0}};
        for (int r = 0; r < 3; ++r)
          for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < 6; ++b)
              square[a * 6 + b] += j[r][a] * j[r][b];
            right[a] += j[r][a] * d[r];
          }
      }
    for (int a = 0; a < 6; ++a)
      square[a * 7] *= 1 + 1e-12;
    solveCholesky(square, right, 6, 1);
    common = rigidAbout(centre, {right[3], right[4], right[5]}, {right[0], right[1], right[2]}) * common;
  }
  return common;
}

PoseErrors::Spread spreadOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at(0.5), at(0.9), values.back()};
}

} // namespace

PoseErrors poseErrors(std::span<const Stack> stacks, std::span<const std::vector<Affine3>> truth,
                      std::span<const std::vector<Affine3>> found, const Mask& body) {
  const Affine3 worldToIndex = inverse(body.geometry.indexToWorld());
  std::vector<SlicePairs> slices;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    const GridGeometry& g = stacks[s].image.geometry;
    const Affine3 map = g.indexToWorld();
    for (std::int64_t k = 0; k < g.size[2]; ++k) {
      SlicePairs slice{truth[s][k], found[s][k], {}};
      std::int64_t looked = 0;
      for (std::int64_t j = 0; j < g.size[1]; j += 3)
        for (std::int64_t i = 0; i < g.size[0]; i += 3) {
          const Vec3 x = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
          ++looked;
          if (inside(body, worldToIndex, slice.truth(x)))
            slice.pairs.push_back({slice.truth(x), slice.found(x)});
        }
      if (100 * static_cast<std::int64_t>(slice.pairs.size()) >= looked) slices.push_back(std::move(slice));
    }
  }
  PoseErrors errors;
  errors.slices = static_cast<std::int64_t>(slices.size());
  if (slices.empty()) return errors;
  const Affine3 common = commonTransform(slices);
  const Vec3 middle = stacks.front().image.geometry.centre();
  errors.commonMillimetres = norm(common(middle) - middle);
  errors.commonDegrees = angleOf(common.linear);
  std::vector<double> millimetres, degrees;
  for (const SlicePairs& slice : slices) {
    double squares = 0;
    for (const Pair& p : slice.pairs) {
      const Vec3 d = p.found - common(p.truth);
      squares += dot(d, d);
    }
    millimetres.push_back(std::sqrt(squares / static_cast<double>(slice.pairs.size())));
    degrees.push_back(angleOf(slice.found.linear * transpose(common.linear * slice.truth.linear)));
  }
  errors.millimetres = spreadOf(std::move(millimetres));
  errors.degrees = spreadOf(std::move(degrees));
  return errors;
}

} // namespace innergs
