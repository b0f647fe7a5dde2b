#include "Core/Acquisition/Observation.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace innergs {
namespace {

void placePlanes(Observation& o, const ProfileQuadrature& quadrature, double sliceSpacing) {
  struct Entry {
    double z;
    int slice, q;
  };
  std::vector<Entry> entries;
  o.perSlice = static_cast<int>(quadrature.offset.size());
  for (int s = 0; s < o.slices; ++s)
    for (int q = 0; q < o.perSlice; ++q)
      entries.push_back({o.sourceSlice[s] + quadrature.offset[q] / sliceSpacing, s, q});
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.z < b.z; });
  o.subPlanes.resize(entries.size());
  o.grid.z.clear();
  for (const Entry& e : entries) {
    o.subPlanes[static_cast<std::size_t>(e.slice) * o.perSlice + e.q] = {
        static_cast<int>(o.grid.z.size()), static_cast<float>(quadrature.weight[e.q])};
    o.grid.z.push_back(e.z);
  }
}

/// mm between sub-planes: a pixel; slices with poses, whose planes meet no voxels of others, need fewer.
double distanceOfPlanes(const Stack& stack) {
  const GridGeometry& g = stack.image.geometry;
  const double pixel = std::min(g.spacing[0], g.spacing[1]), thickness = effectiveThickness(stack);
  constexpr double kPosed = 1.25; // pixels, at most
  return stack.poses.empty() ? pixel
                             : std::max(pixel, thickness / std::ceil(thickness / (kPosed * pixel) - 1e-3));
}

/// Repeats the sub-planes for every point of a pixel.
void placePoints(Observation& o, std::span<const PixelPoint> points) {
  if (points.size() == 1) return;
  o.points.clear();
  for (const PixelPoint& point : points)
    o.points.push_back(point.offset);
  const std::vector<Observation::SubPlane> planes = std::move(o.subPlanes);
  const auto perSlice = static_cast<std::size_t>(o.perSlice);
  o.subPlanes.clear();
  for (std::size_t first = 0; first < planes.size(); first += perSlice)
    for (std::size_t p = 0; p < points.size(); ++p)
      for (std::size_t q = first; q < first + perSlice; ++q)
        o.subPlanes.push_back({planes[q].plane + static_cast<int>(p) * o.grid.planes(),
                               static_cast<float>(planes[q].weight * points[p].weight)});
  o.perSlice *= static_cast<int>(points.size());
}

ClosedFormPsf gaussianPsf(const Stack& stack, const Affine3& worldToModel, const Affine3& pose) {
  const double tau = effectiveThickness(stack) / kFwhm;
  const Vec3 n = worldToModel.linear * (pose.linear * column(stack.image.geometry.direction, 2));
  ClosedFormPsf psf;
  psf.active = true;
  int t = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      psf.covariance[t++] = static_cast<float>(tau * tau * n[i] * n[j]);
  return psf;
}

Observation observeSlices(const Stack& stack, int first, int last, const Affine3& worldToModel,
                          const Affine3& pose, const IntensityMap& map, bool closedForm,
                          bool smoothAlongNormal, double resolution) {
  const GridGeometry& g = stack.image.geometry;
  Observation o;
  o.grid.indexToModel = worldToModel * pose * g.indexToWorld();
  o.grid.nx = static_cast<int>(g.size[0]);
  o.grid.ny = static_cast<int>(g.size[1]);
  const std::size_t nx = g.size[0], ny = g.size[1], stride = o.grid.stride();
  const double inverseScale = 1 / map.scale;
  o.target.reserve(stride * ny * static_cast<std::size_t>(last - first));
  o.weight.reserve(o.target.capacity());
  for (int k = first; k < last; ++k) {
    const std::size_t source = static_cast<std::size_t>(k) * nx * ny, at = o.target.size();
    o.target.resize(at + stride * ny, 0.f);
    o.weight.resize(at + stride * ny, 0);
    std::int64_t seen = 0;
    for (std::size_t y = 0; y < ny; ++y)
      for (std::size_t x = 0; x < nx; ++x) {
        const std::size_t v = source + y * nx + x;
        if (!isKnown(stack, v)) continue;
        o.target[at + y * stride + x] =
            static_cast<float>((stack.image.voxels[v] - map.offset) * inverseScale);
        o.weight[at + y * stride + x] = 1;
        ++seen;
      }
    if (seen == 0) {
      o.target.resize(at);
      o.weight.resize(at);
      continue;
    }
    o.sourceSlice.push_back(k);
    o.samples += seen;
  }
  o.slices = static_cast<int>(o.sourceSlice.size());
  ProfileQuadrature quadrature{{0.0}, {1.0}};
  if (closedForm && stack.profile == SliceProfile::Gaussian)
    o.psf = gaussianPsf(stack, worldToModel, pose);
  else
    quadrature = profileQuadrature(stack.profile, effectiveThickness(stack), distanceOfPlanes(stack));
  if (smoothAlongNormal && quadrature.offset.size() > 2)
    quadrature = twoPointQuadrature(stack.profile, effectiveThickness(stack));
  placePlanes(o, quadrature, g.spacing[2]);
  if (resolution > 0)
    placePoints(o, pixelPoints(pixelQuadrature(stack.profile, stack.pixelWidth, resolution), g.spacing));
  return o;
}

} // namespace

SampleGrid Observation::gridOf(std::size_t point) const {
  SampleGrid shifted = grid;
  shifted.indexToModel.offset = grid.indexToModel({points[point][0], points[point][1], 0});
  return shifted;
}

ProfileQuadrature pixelQuadrature(SliceProfile profile, double width, double resolution) {
  const bool thin = profile == SliceProfile::Point;
  return profileQuadrature(thin ? SliceProfile::Box : profile, width, resolution);
}

std::vector<PixelPoint> pixelPoints(const ProfileQuadrature& edge, const Vec3& spacing) {
  std::vector<PixelPoint> points;
  for (std::size_t j = 0; j < edge.offset.size(); ++j)
    for (std::size_t i = 0; i < edge.offset.size(); ++i)
      points.push_back(
          {{edge.offset[i] / spacing[0], edge.offset[j] / spacing[1]}, edge.weight[i] * edge.weight[j]});
  return points;
}

double effectiveThickness(const Stack& stack) {
  return stack.thickness > 0 ? stack.thickness : stack.image.geometry.spacing[2];
}

ProfileQuadrature profileQuadrature(SliceProfile profile, double thickness, double resolution) {
  const int n = std::clamp(static_cast<int>(std::lround(thickness / resolution)), 1, 256);
  if (profile == SliceProfile::Point || n == 1) return {{0.0}, {1.0}};
  ProfileQuadrature q;
  if (profile == SliceProfile::Box) {
    for (int i = 0; i < n; ++i) {
      q.offset.push_back(((i + 0.5) / n - 0.5) * thickness);
      q.weight.push_back(1.0 / n);
    }
    return q;
  }
  const double tau = thickness / kFwhm, reach = 3.2 * tau;
  const int m = std::clamp(2 * static_cast<int>(std::ceil(reach / resolution)) + 1, 5, 257);
  double sum = 0;
  for (int i = 0; i < m; ++i) {
    const double x = reach * (2.0 * i / (m - 1) - 1);
    q.offset.push_back(x);
    q.weight.push_back(std::exp(-0.5 * x * x / (tau * tau)));
    sum += q.weight.back();
  }
  for (double& w : q.weight)
    w /= sum;
  return q;
}

ProfileQuadrature twoPointQuadrature(SliceProfile profile, double thickness) {
  const double x = profile == SliceProfile::Gaussian ? thickness / kFwhm : thickness / std::sqrt(12.0);
  return {{-x, x}, {0.5, 0.5}};
}

std::vector<Observation> observe(const Stack& stack, const Affine3& modelToWorld, const IntensityMap& map,
                                 bool closedForm, bool smoothAlongNormal, double resolution) {
  const Affine3 worldToModel = inverse(modelToWorld);
  const int slices = static_cast<int>(stack.image.geometry.size[2]);
  std::vector<Observation> result;
  const auto add = [&](int first, int last, const Affine3& pose) {
    Observation o =
        observeSlices(stack, first, last, worldToModel, pose, map, closedForm, smoothAlongNormal, resolution);
    if (o.slices > 0) result.push_back(std::move(o));
  };
  if (stack.poses.empty())
    add(0, slices, {});
  else
    for (int k = 0; k < slices; ++k)
      add(k, k + 1, stack.poses[k]);
  return result;
}

Observation coarsened(const Observation& fine) {
  const double pixel = norm(column(fine.grid.indexToModel.linear, 0));
  const double slice = norm(column(fine.grid.indexToModel.linear, 2));
  const bool mergeSlices = fine.perSlice == 1 && fine.slices > 3 && slice < 1.4 * pixel;
  const int fx = 2, fy = 2, fz = mergeSlices ? 2 : 1;
  Observation o;
  o.psf = fine.psf;
  o.points = fine.points;
  for (auto& point : o.points)
    for (double& x : point)
      x /= 2;
  o.subset = fine.subset;
  o.perSlice = fine.perSlice;
  Affine3 index; // coarse index → fine index
  index.linear = diagonal({2, 2, 1});
  index.offset = {0.5, 0.5, 0};
  o.grid.indexToModel = fine.grid.indexToModel * index;
  o.grid.nx = (fine.grid.nx + fx - 1) / fx;
  o.grid.ny = (fine.grid.ny + fy - 1) / fy;
  o.slices = (fine.slices + fz - 1) / fz;
  o.target.assign(o.grid.planeSize() * o.slices, 0.f);
  o.weight.assign(o.target.size(), 0);
  const int fs = fine.grid.stride(), cs = o.grid.stride();
  for (int s = 0; s < o.slices; ++s) {
    o.sourceSlice.push_back(fine.sourceSlice[s * fz]);
    for (int y = 0; y < o.grid.ny; ++y)
      for (int x = 0; x < o.grid.nx; ++x) {
        float sum = 0;
        int n = 0;
        for (int c = s * fz; c < std::min(fine.slices, (s + 1) * fz); ++c)
          for (int b = y * fy; b < std::min(fine.grid.ny, (y + 1) * fy); ++b)
            for (int a = x * fx; a < std::min(fine.grid.nx, (x + 1) * fx); ++a) {
              const std::size_t v = c * fine.sliceSize() + static_cast<std::size_t>(b) * fs + a;
              if (!fine.weight[v]) continue;
              sum += fine.target[v];
              ++n;
            }
        if (!n) continue;
        const std::size_t v = s * o.sliceSize() + static_cast<std::size_t>(y) * cs + x;
        o.target[v] = sum / static_cast<float>(n);
        o.weight[v] = 1;
        ++o.samples;
      }
  }
  if (mergeSlices) {
    for (int s = 0; s < o.slices; ++s) {
      const int last = std::min(fine.slices, (s + 1) * fz) - 1;
      o.grid.z.push_back(0.5 * (fine.grid.z[s * fz] + fine.grid.z[last]));
      o.subPlanes.push_back({s, 1.f});
    }
  } else if (fine.slices == 1 && fine.perSlice > 2 && fine.points.size() == 1) {
    for (int q = 0; q < fine.perSlice; q += 2) {
      double z = 0, weight = 0;
      for (int p = q; p < std::min(q + 2, fine.perSlice); ++p) {
        const auto& [plane, share] = fine.subPlanes[static_cast<std::size_t>(p)];
        z += share * fine.grid.z[static_cast<std::size_t>(plane)];
        weight += share;
      }
      o.subPlanes.push_back({q / 2, static_cast<float>(weight)});
      o.grid.z.push_back(z / weight);
    }
    o.perSlice = static_cast<int>(o.subPlanes.size());
  } else {
    o.grid.z = fine.grid.z;
    o.subPlanes = fine.subPlanes;
  }
  return o;
}

} // namespace innergs
