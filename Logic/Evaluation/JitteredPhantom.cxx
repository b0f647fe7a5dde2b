#include "Evaluation/JitteredPhantom.h"

#include "Core/Base/Random.h"

#include <cmath>
#include <numbers>

namespace innergs {
namespace {

double normal(Random& random) { // Box-Muller
  const double u = 1 - random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// A soft ellipsoid or, if long along y, a rod.
struct Part {
  Vec3 centre, radius; // mm
  double cosine, sine; // of its rotation about z
  double value;

  double at(const Vec3& x) const {
    const Vec3 d = x - centre;
    const double u = (cosine * d[0] + sine * d[1]) / radius[0], v = (cosine * d[1] - sine * d[0]) / radius[1],
                 w = d[2] / radius[2];
    const double r = std::sqrt(u * u + v * v + w * w);
    return value / (1 + std::exp(6 * (r - 1)));
  }
};

} // namespace

TimeSeries makeJitteredPhantom(const JitteredPhantom& phantom) {
  Random random(phantom.seed);
  const GridGeometry& g = phantom.geometry;
  const Vec3 centre = g.centre(), extent = g.extent();
  std::vector<Part> parts;
  parts.push_back({centre, {0.42 * extent[0], 0.46 * extent[1], 0.7 * extent[2]}, 1, 0, 1400});
  for (int n = 0; n < 140; ++n) {
    Part part;
    const double turn = 2 * std::numbers::pi * random.uniform();
    part.cosine = std::cos(turn);
    part.sine = std::sin(turn);
    for (int a = 0; a < 3; ++a)
      part.centre[a] = centre[a] + 0.8 * (random.uniform() - 0.5) * extent[a];
    const double size = 2.5 + 4 * random.uniform();
    part.radius = {size, n % 3 == 0 ? 3 * size : size, 6 + 8 * random.uniform()};
    part.value = 3000 * (random.uniform() - 0.4);
    parts.push_back(part);
  }
  TimeSeries series;
  series.geometry = g;
  series.name = "jittered phantom";
  const Affine3 map = g.indexToWorld();
  for (int f = 0; f < phantom.frames; ++f) {
    const double time = phantom.interval * f;
    const double angle = (phantom.swing * std::sin(2 * std::numbers::pi * time / phantom.period) +
                          phantom.angleJitter * normal(random)) *
                         std::numbers::pi / 180;
    const Vec3 shift{phantom.shiftJitter * normal(random), phantom.shiftJitter * normal(random), 0};
    auto& frame = series.frames.emplace_back();
    frame.reserve(static_cast<std::size_t>(g.voxelCount()));
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const Vec3 x = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
          const double moving = 1 / (1 + std::exp((x[1] - centre[1]) / 4)); // share of the joint's far side
          const double a = -moving * angle;
          const Vec3 d = x - centre;
          const Vec3 from =
              centre +
              Vec3{std::cos(a) * d[0] - std::sin(a) * d[1], std::sin(a) * d[0] + std::cos(a) * d[1], d[2]} -
              moving * shift;
          double value = 100;
          for (const Part& part : parts)
            value += part.at(from);
          value = std::max(0.0, value);
          const double real = value + phantom.noise * normal(random),
                       imaginary = phantom.noise * normal(random);
          frame.push_back(static_cast<float>(std::hypot(real, imaginary)));
        }
    series.times.push_back(time);
  }
  return series;
}

} // namespace innergs
