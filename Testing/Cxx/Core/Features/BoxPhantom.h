#pragma once
#include "Core/Features/Labelmap.h"
#include "Core/Model/GaussianField.h"

#include <cmath>

namespace innergs::testing {

/// Boxes with individual intensities and labels (1, 2, 3 on 0), on an oblique grid of 2 mm; the field has
/// a Gaussian in each voxel.
struct BoxPhantom {
  Labelmap labels;
  GaussianField field;

  explicit BoxPhantom(std::int64_t n = 14) {
    GridGeometry& g = labels.geometry;
    const double c = std::cos(0.3), s = std::sin(0.3);
    g.size = {n, n, n};
    g.spacing = {2, 2, 2};
    g.origin = {-10, 20, 30};
    g.direction = Mat3{{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}};
    field.domain = g;
    field.intensityScale = 1000;
    field.modelToWorld = {g.direction, g.origin};
    for (std::int64_t k = 0; k < n; ++k)
      for (std::int64_t j = 0; j < n; ++j)
        for (std::int64_t i = 0; i < n; ++i) {
          const int label = labelAt(i, j, k, n);
          labels.voxels.push_back(static_cast<std::uint16_t>(label));
          Gaussian gaussian{};
          const std::int64_t index[3] = {i, j, k};
          for (int a = 0; a < 3; ++a) {
            gaussian.mean[a] = static_cast<float>(2 * index[a]);
            gaussian.logScale[a] = std::log(0.8f);
          }
          gaussian.quaternion[0] = 1;
          gaussian.intensity = 0.2f + 0.25f * static_cast<float>(label);
          field.gaussians.push_back(gaussian);
        }
  }

  static int labelAt(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t n) {
    const auto within = [&](std::int64_t x, double low, double high) {
      return static_cast<double>(x) >= low * static_cast<double>(n) &&
             static_cast<double>(x) < high * static_cast<double>(n);
    };
    if (within(i, 0.1, 0.5) && within(j, 0.1, 0.5) && within(k, 0.2, 0.8)) return 1;
    if (within(i, 0.5, 0.9) && within(j, 0.1, 0.6) && within(k, 0.3, 0.9)) return 2;
    if (within(i, 0.2, 0.8) && within(j, 0.6, 0.9) && within(k, 0.1, 0.7)) return 3;
    return 0;
  }

  /// Only the labels of every k-th slice.
  Labelmap every(std::int64_t step) const {
    Labelmap out = labels;
    const std::int64_t plane = labels.geometry.size[0] * labels.geometry.size[1];
    for (std::int64_t k = 0; k < labels.geometry.size[2]; ++k) {
      out.labelled.push_back(k % step == 0);
      if (k % step != 0) std::fill_n(out.voxels.begin() + k * plane, plane, std::uint16_t{0});
    }
    return out;
  }
};

} // namespace innergs::testing
