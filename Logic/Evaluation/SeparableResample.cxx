#include "Evaluation/SeparableResample.h"

#include <algorithm>
#include <numbers>

namespace innergs {
namespace {

constexpr double onGrid = 1e-6; // voxel

struct Line {
  std::vector<std::int64_t> first; // first[x] … + taps − 1, before border handling
  std::vector<std::array<double, 8>> weights;
  int taps = 1;
  bool mirrored = false; // cubic coefficients continue by reflection, samples by replication
  bool identity = true;  // every position is a sample
};

Line makeLine(std::int64_t size, std::int64_t gridSize, double offset, double scale, Interpolation kind) {
  std::vector<double> position(static_cast<std::size_t>(gridSize));
  Line line;
  for (std::int64_t x = 0; x < gridSize; ++x) {
    double p = std::clamp(offset + scale * double(x), 0.0, double(size - 1));
    if (std::abs(p - std::round(p)) < onGrid)
      p = std::round(p);
    else
      line.identity = false;
    position[x] = p;
  }
  line.first.resize(position.size());
  line.weights.resize(position.size());
  line.taps = line.identity ? 1 : kind == Interpolation::Linear ? 2 : kind == Interpolation::Cubic ? 4 : 8;
  line.mirrored = kind == Interpolation::Cubic;
  for (std::size_t x = 0; x < position.size(); ++x) {
    const double base = std::floor(position[x]), f = position[x] - base;
    line.first[x] = static_cast<std::int64_t>(base) - (line.taps / 2 - (line.taps > 1));
    auto& w = line.weights[x];
    if (line.taps == 1) {
      w[0] = 1;
    } else if (kind == Interpolation::Linear) {
      w[0] = 1 - f;
      w[1] = f;
    } else if (kind == Interpolation::Cubic) {
      const double g = 1 - f;
      w[0] = g * g * g / 6;
      w[1] = 2.0 / 3 - f * f + f * f * f / 2;
      w[2] = 2.0 / 3 - g * g + g * g * g / 2;
      w[3] = f * f * f / 6;
    } else {
      w = lanczosWeights(f);
    }
  }
  return line;
}

std::int64_t borderIndex(std::int64_t i, std::int64_t n, bool mirrored) {
  if (!mirrored) return std::clamp<std::int64_t>(i, 0, n - 1);
  if (n == 1) return 0;
  const std::int64_t period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

// Arrays as [outer][n][inner]: one axis of a volume in memory order.
struct LineShape {
  std::int64_t outer, n, inner;
};
LineShape shapeAlong(const std::array<std::int64_t, 3>& size, int axis) {
  return axis == 0   ? LineShape{size[1] * size[2], size[0], 1}
         : axis == 1 ? LineShape{size[2], size[1], size[0]}
                     : LineShape{1, size[2], size[0] * size[1]};
}
// Work is divided into (outer, piece of inner), so that every axis keeps all threads busy.
constexpr std::int64_t pieceSize = 1024;

// Samples → cubic B-spline coefficients (Unser 1999), mirrored borders.
void prefilter(std::vector<float>& values, const LineShape& shape, ThreadPool& pool) {
  if (shape.n < 2) return;
  const double pole = std::sqrt(3.0) - 2, gain = 6;
  const std::int64_t horizon = std::min<std::int64_t>(shape.n, 32);
  const std::int64_t width = std::min<std::int64_t>(shape.inner, 64),
                     pieces = (shape.inner + width - 1) / width;
  pool.blocks(shape.outer * pieces, 64, [&](std::int64_t from, std::int64_t to) {
    std::vector<double> line(static_cast<std::size_t>(shape.n * width));
    for (std::int64_t item = from; item < to; ++item) {
      const std::int64_t start = item % pieces * width, count = std::min(width, shape.inner - start);
      float* base = values.data() + item / pieces * shape.n * shape.inner + start;
      const auto at = [&](std::int64_t k) { return line.data() + k * width; };
      for (std::int64_t k = 0; k < shape.n; ++k)
        for (std::int64_t c = 0; c < count; ++c)
          at(k)[c] = gain * double(base[k * shape.inner + c]);
      for (std::int64_t c = 0; c < count; ++c) {
        double sum = at(0)[c], power = pole;
        if (horizon < shape.n) {
          for (std::int64_t k = 1; k < horizon; ++k, power *= pole)
            sum += power * at(k)[c];
        } else { // exact for short lines
          const double last = std::pow(pole, double(shape.n - 1));
          double back = last * last / pole;
          sum += last * at(shape.n - 1)[c];
          for (std::int64_t k = 1; k + 1 < shape.n; ++k, power *= pole, back /= pole)
            sum += (power + back) * at(k)[c];
          sum /= 1 - last * last;
        }
        at(0)[c] = sum;
      }
      for (std::int64_t k = 1; k < shape.n; ++k)
        for (std::int64_t c = 0; c < count; ++c)
          at(k)[c] += pole * at(k - 1)[c];
      for (std::int64_t c = 0; c < count; ++c)
        at(shape.n - 1)[c] = pole / (pole * pole - 1) * (at(shape.n - 1)[c] + pole * at(shape.n - 2)[c]);
      for (std::int64_t k = shape.n - 2; k >= 0; --k)
        for (std::int64_t c = 0; c < count; ++c)
          at(k)[c] = pole * (at(k + 1)[c] - at(k)[c]);
      for (std::int64_t k = 0; k < shape.n; ++k)
        for (std::int64_t c = 0; c < count; ++c)
          base[k * shape.inner + c] = static_cast<float>(at(k)[c]);
    }
  });
}

std::vector<float> interpolate(const std::vector<float>& in, const LineShape& shape, const Line& line,
                               ThreadPool& pool) {
  const auto n = static_cast<std::int64_t>(line.first.size());
  std::vector<float> out(static_cast<std::size_t>(shape.outer * n * shape.inner));
  if (shape.inner == 1) {
    pool.blocks(shape.outer, 64, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t o = from; o < to; ++o)
        for (std::int64_t x = 0; x < n; ++x) {
          double sum = 0;
          for (int t = 0; t < line.taps; ++t)
            sum +=
                line.weights[x][t] * in[o * shape.n + borderIndex(line.first[x] + t, shape.n, line.mirrored)];
          out[o * n + x] = static_cast<float>(sum);
        }
    });
    return out;
  }
  const std::int64_t pieces = (shape.inner + pieceSize - 1) / pieceSize;
  pool.run(shape.outer * pieces, [&](std::int64_t item) {
    const std::int64_t start = item % pieces * pieceSize, count = std::min(pieceSize, shape.inner - start);
    const float* source = in.data() + item / pieces * shape.n * shape.inner + start;
    float* target = out.data() + item / pieces * n * shape.inner + start;
    for (std::int64_t x = 0; x < n; ++x) {
      float* to = target + x * shape.inner;
      for (int t = 0; t < line.taps; ++t) {
        const float* from = source + borderIndex(line.first[x] + t, shape.n, line.mirrored) * shape.inner;
        const auto w = static_cast<float>(line.weights[x][t]);
        if (t == 0)
          for (std::int64_t c = 0; c < count; ++c)
            to[c] = w * from[c];
        else
          for (std::int64_t c = 0; c < count; ++c)
            to[c] += w * from[c];
      }
    }
  });
  return out;
}

} // namespace

std::array<double, 8> lanczosWeights(double fraction) {
  std::array<double, 8> weights{};
  const auto sinc = [](double x) {
    return std::abs(x) < 1e-12 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
  };
  double sum = 0;
  for (int t = 0; t < 8; ++t) {
    const double x = fraction - (t - 3);
    weights[t] = std::abs(x) < 4 ? sinc(x) * sinc(x / 4) : 0;
    sum += weights[t];
  }
  for (double& w : weights)
    w /= sum;
  return weights;
}

std::optional<AxisMap> alignedAxes(const GridGeometry& image, const GridGeometry& grid) {
  const Affine3 toImage = inverse(image.indexToWorld()) * grid.indexToWorld();
  AxisMap map;
  std::array<bool, 3> used{};
  for (int a = 0; a < 3; ++a) {
    int best = 0;
    for (int s = 1; s < 3; ++s)
      if (std::abs(toImage.linear[s][a]) > std::abs(toImage.linear[best][a])) best = s;
    for (int s = 0; s < 3; ++s)
      if (s != best && std::abs(toImage.linear[s][a]) * double(grid.size[a]) > 1e-4) return std::nullopt;
    if (used[best]) return std::nullopt;
    used[best] = true;
    map.axis[a] = best;
    map.scale[a] = toImage.linear[best][a];
    map.offset[a] = toImage.offset[best];
  }
  return map;
}

std::vector<float> resampleAligned(const Volume& image, const GridGeometry& grid, const AxisMap& map,
                                   Interpolation kind, ThreadPool& pool) {
  // First brings the image into the grid's axis order.
  const auto& n = image.geometry.size;
  const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
  std::array<std::int64_t, 3> size{n[map.axis[0]], n[map.axis[1]], n[map.axis[2]]};
  std::vector<float> values(image.voxels.size());
  pool.run(size[2], [&](std::int64_t k) {
    float* out = values.data() + k * size[0] * size[1];
    for (std::int64_t j = 0; j < size[1]; ++j) {
      const float* in = image.voxels.data() + j * stride[map.axis[1]] + k * stride[map.axis[2]];
      for (std::int64_t i = 0; i < size[0]; ++i)
        *out++ = in[i * stride[map.axis[0]]];
    }
  });
  for (int a = 0; a < 3; ++a) {
    const Line line = makeLine(size[a], grid.size[a], map.offset[a], map.scale[a], kind);
    const LineShape shape = shapeAlong(size, a);
    if (kind == Interpolation::Cubic && !line.identity) prefilter(values, shape, pool);
    values = interpolate(values, shape, line, pool);
    size[a] = grid.size[a];
  }
  return values;
}

} // namespace innergs
