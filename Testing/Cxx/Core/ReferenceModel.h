#pragma once
#include "Core/Fit/Loss.h"
#include "Core/Model/GaussianMath.h"

#include <algorithm>
#include <numeric>
#include <vector>

/// A second implementation of the field, its slice profile and its losses, in double precision and by brute
/// force: no grid, no binning, no row limits. The engine's results are compared with it.
namespace innergs::testing {

/// A Gaussian's parameters in double precision, in the order of struct Gaussian.
using Parameters = std::array<double, 16>;

inline std::vector<Parameters> parametersOf(const GaussianField& field) {
  std::vector<Parameters> all;
  for (const Gaussian& g : field.gaussians) {
    const float* x = reinterpret_cast<const float*>(&g);
    Parameters p;
    std::copy_n(x, 16, p.begin());
    all.push_back(p);
  }
  return all;
}

/// Cubic convolution of all voxels with Keys' kernel of a = −3/4; edge voxels are repeated.
inline double sampleCubic(const Volume& volume, const Vec3& index) {
  const auto kernel = [](double s) {
    s = std::abs(s);
    return s <= 1   ? 1.25 * s * s * s - 2.25 * s * s + 1
           : s <= 2 ? -0.75 * (s * s * s - 5 * s * s + 8 * s - 4)
                    : 0.0;
  };
  const auto& n = volume.geometry.size;
  Vec3 at;
  for (int a = 0; a < 3; ++a)
    at[a] = std::clamp(index[a], 0.0, static_cast<double>(n[a] - 1));
  double sum = 0;
  for (std::int64_t k = -2; k < n[2] + 2; ++k)
    for (std::int64_t j = -2; j < n[1] + 2; ++j)
      for (std::int64_t i = -2; i < n[0] + 2; ++i) {
        const double weight =
            kernel(at[0] - double(i)) * kernel(at[1] - double(j)) * kernel(at[2] - double(k));
        const auto inside = [&](std::int64_t x, int axis) {
          return std::clamp<std::int64_t>(x, 0, n[axis] - 1);
        };
        if (weight != 0)
          sum += weight * volume.voxels[inside(i, 0) + n[0] * (inside(j, 1) + n[1] * inside(k, 2))];
      }
  return sum;
}

/// One Gaussian prepared for evaluation: precision, weight, and the additional covariance of a closed-form
/// slice profile.
struct ReferenceGaussian {
  double mean[3], precision[6], weight, intensity, slope[3], radius2;

  ReferenceGaussian(const Parameters& p, Blending blending, double cutoff, const float* blur = nullptr) {
    double r[9], scaled[9], covariance[6], blurred[6], ignored[6];
    math::rotation(p.data() + 6, r);
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i)
        scaled[3 * i + k] = r[3 * i + k] * std::exp(p[3 + k]);
    math::outer(scaled, covariance);
    for (int i = 0; i < 6; ++i)
      blurred[i] = covariance[i] + (blur ? static_cast<double>(blur[i]) : 0.0);
    const double det = math::invertSymmetric(covariance, ignored);
    const double blurredDet = math::invertSymmetric(blurred, precision);
    weight = blending == Blending::Alpha ? 1 / (1 + std::exp(-p[10])) : std::exp(p[10]);
    weight *= std::sqrt(det / blurredDet);
    std::copy_n(p.data(), 3, mean);
    std::copy_n(p.data() + 12, 3, slope);
    intensity = p[11];
    radius2 = cutoff * cutoff;
  }

  double mahalanobis(const Vec3& x) const {
    const double d[3] = {x[0] - mean[0], x[1] - mean[1], x[2] - mean[2]};
    return precision[0] * d[0] * d[0] + precision[3] * d[1] * d[1] + precision[5] * d[2] * d[2] +
           2 * (precision[1] * d[0] * d[1] + precision[2] * d[0] * d[2] + precision[4] * d[1] * d[2]);
  }

  /// w·p′ at x (model frame).
  double contribution(const Vec3& x) const {
    const double m = mahalanobis(x);
    return m > radius2 ? 0 : weight * (std::exp(-0.5 * m) - std::exp(-0.5 * radius2));
  }

  /// Adds w·p′ and w·p′·(c + g·d) at x.
  void add(const Vec3& x, bool linear, double& weights, double& numerators) const {
    const double p = contribution(x);
    double value = intensity;
    for (int a = 0; a < 3 && linear; ++a)
      value += slope[a] * (x[a] - mean[a]);
    weights += p;
    numerators += p * value;
  }
};

/// The value at x; alpha blending takes the Gaussians in the given order.
inline double blend(const GaussianField& field, const std::vector<ReferenceGaussian>& gaussians,
                    const std::vector<std::size_t>& order, const Vec3& x) {
  double weights = 0, numerators = 0, transmittance = 1, image = 0;
  for (std::size_t i : order) {
    gaussians[i].add(x, field.linearIntensity, weights, numerators);
    const double a = gaussians[i].contribution(x);
    image += transmittance * a * gaussians[i].intensity;
    transmittance *= 1 - a;
  }
  if (field.blending == Blending::Alpha) return image;
  return field.blending == Blending::Normalised ? numerators / (weights + field.epsilon) : numerators;
}

/// Indices sorted by the distance of the centre to the plane of index z, nearest first.
inline std::vector<std::size_t> depthOrder(const GaussianField& field, const Affine3& modelToIndex,
                                           double z) {
  std::vector<std::size_t> order(field.gaussians.size());
  std::vector<double> depth;
  for (const Gaussian& g : field.gaussians)
    depth.push_back(std::abs(modelToIndex({g.mean[0], g.mean[1], g.mean[2]})[2] - z));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return depth[a] < depth[b]; });
  return order;
}

/// The field's value (normalised intensity) at a point of the model frame; alpha blending: on a slice normal
/// to the third axis of `modelToIndex`.
inline double referenceValue(const GaussianField& field, const Vec3& x, const Affine3& modelToIndex = {}) {
  std::vector<ReferenceGaussian> gaussians;
  for (const Parameters& p : parametersOf(field))
    gaussians.emplace_back(p, field.blending, field.cutoff);
  return blend(field, gaussians, depthOrder(field, modelToIndex, modelToIndex(x)[2]), x);
}

/// The slices of an observation, tightly packed [slice][y][x]. The depth order is that of `field`, whatever
/// the parameters, since gradients keep it fixed.
inline std::vector<double> referenceSlices(const Observation& o, const GaussianField& field,
                                           const std::vector<Parameters>& parameters) {
  std::vector<ReferenceGaussian> gaussians;
  for (const Parameters& p : parameters)
    gaussians.emplace_back(p, field.blending, field.cutoff, o.psf.active ? o.psf.covariance : nullptr);
  const Affine3 modelToIndex = inverse(o.grid.indexToModel);
  std::vector<std::vector<std::size_t>> orders;
  for (double z : o.grid.z)
    orders.push_back(depthOrder(field, modelToIndex, z));
  std::vector<double> image;
  for (int s = 0; s < o.slices; ++s)
    for (int y = 0; y < o.grid.ny; ++y)
      for (int x = 0; x < o.grid.nx; ++x) {
        double value = 0;
        for (int q = 0; q < o.perSlice; ++q) {
          const auto [plane, share] = o.subPlanes[static_cast<std::size_t>(s) * o.perSlice + q];
          const auto& point = o.points[static_cast<std::size_t>(plane / o.grid.planes())];
          const int depth = plane % o.grid.planes();
          const Vec3 at = o.grid.indexToModel({x + point[0], y + point[1], o.grid.z[depth]});
          value += share * blend(field, gaussians, orders[depth], at);
        }
        image.push_back(value);
      }
  return image;
}

/// Σ(1 − SSIM) of a slice, 11×11 Gaussian window of σ 1.5, zero-padded; unobserved samples count as equal.
inline double referenceSsimLoss(const double* image, const double* target, int nx, int ny) {
  double window[11], total = 0, loss = 0;
  for (int k = 0; k < 11; ++k)
    total += window[k] = std::exp(-0.5 * (k - 5) * (k - 5) / 2.25);
  for (double& w : window)
    w /= total;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      double mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
      for (int b = std::max(0, j - 5); b <= std::min(ny - 1, j + 5); ++b)
        for (int a = std::max(0, i - 5); a <= std::min(nx - 1, i + 5); ++a) {
          const double w = window[a - i + 5] * window[b - j + 5], x = image[b * nx + a],
                       y = target[b * nx + a];
          mx += w * x, my += w * y, xx += w * x * x, yy += w * y * y, xy += w * x * y;
        }
      loss += 1 - (2 * mx * my + 1e-4) * (2 * (xy - mx * my) + 9e-4) /
                      ((mx * mx + my * my + 1e-4) * (xx - mx * mx + yy - my * my + 9e-4));
    }
  return loss;
}

/// The loss of an observation for slices rendered by referenceSlices().
inline double referenceLoss(const Observation& o, const LossKinds& kinds, const std::vector<double>& slices) {
  const int nx = o.grid.nx, ny = o.grid.ny;
  double loss = 0;
  std::vector<double> image(nx * ny), target(nx * ny);
  for (int s = 0; s < o.slices; ++s) {
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const std::size_t at = s * o.sliceSize() + static_cast<std::size_t>(y) * o.grid.stride() + x;
        const int i = y * nx + x;
        target[i] = o.target[at];
        image[i] = o.weight[at] ? slices[static_cast<std::size_t>(s) * nx * ny + i] : target[i];
        const double e = std::abs(image[i] - target[i]), delta = kinds.huberDelta;
        const double w = kinds.pointWeight;
        if (kinds.kind == LossKind::L1) loss += w * e;
        if (kinds.kind == LossKind::L2) loss += w * 0.5 * e * e;
        if (kinds.kind == LossKind::Huber) loss += w * (e <= delta ? 0.5 * e * e : delta * (e - 0.5 * delta));
      }
    if (kinds.ssimWeight > 0)
      loss += kinds.ssimWeight * referenceSsimLoss(image.data(), target.data(), nx, ny);
  }
  return loss;
}

} // namespace innergs::testing
