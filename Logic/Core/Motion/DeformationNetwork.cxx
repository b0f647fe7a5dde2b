#include "Core/Motion/DeformationNetwork.h"

#include "Core/Base/Error.h"
#include "Core/Base/Random.h"
#include "Core/Prediction/DenseLayer.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr int kC = DeformationNetwork::kChannels, kW = DeformationNetwork::kWidth,
              kO = DeformationNetwork::kOutputs;
constexpr std::int64_t kPointsPerBlock = 128; // points whose activations stay in the cache
constexpr std::int64_t kChunks = 8; // each sums its own gradient, so that no sum depends on the threads
constexpr std::array<std::array<int, 2>, 3> kPairs{{{0, 1}, {0, 2}, {1, 2}}};

/// Where the planes of a level begin among the parameters.
struct Planes {
  std::array<std::size_t, 3> space, time; // of kPairs; of (axis, t): [t][node][channel]
  std::size_t end;
};

Planes planesOf(const DeformationNetwork::Level& level, std::size_t at) {
  Planes p{};
  for (int n = 0; n < 3; ++n) {
    p.space[n] = at;
    at += static_cast<std::size_t>(level.size[kPairs[n][0]]) * level.size[kPairs[n][1]] * kC;
  }
  for (int a = 0; a < 3; ++a) {
    p.time[a] = at;
    at += static_cast<std::size_t>(level.size[a]) * level.times * kC;
  }
  p.end = at;
  return p;
}

std::vector<Planes> planesOf(const DeformationNetwork& network) {
  std::vector<Planes> planes;
  std::size_t at = 0;
  for (const auto& level : network.levels) {
    planes.push_back(planesOf(level, at));
    at = planes.back().end;
  }
  return planes;
}

/// Two hidden layers and the heads.
std::array<DenseLayer, 3> layersOf(const DeformationNetwork& network) {
  const DenseLayer first{network.planeParameters(), network.features(), kW, true};
  const DenseLayer second{first.end(), kW, kW, true};
  return {first, second, DenseLayer{second.end(), kW, kO, false}};
}

TimeSpline::Weights timeWeights(const DeformationNetwork& network, const DeformationNetwork::Level& level,
                                double time) {
  return TimeSpline{network.start, network.end, level.times}.at(time);
}

std::size_t lineCount(const DeformationNetwork& network) {
  std::size_t count = 0;
  for (const auto& level : network.levels)
    count += static_cast<std::size_t>(level.size[0] + level.size[1] + level.size[2]) * kC;
  return count;
}

/// The planes over time, interpolated at one: [level][axis][node][channel].
std::vector<float> linesAt(const DeformationNetwork& network, double time) {
  std::vector<float> lines;
  lines.reserve(lineCount(network));
  const std::vector<Planes> planes = planesOf(network);
  for (std::size_t l = 0; l < planes.size(); ++l) {
    const auto& level = network.levels[l];
    const TimeSpline::Weights at = timeWeights(network, level, time);
    for (int a = 0; a < 3; ++a) {
      const std::size_t row = static_cast<std::size_t>(level.size[a]) * kC;
      const float* node = network.parameters.data() + planes[l].time[a] + at.first * row;
      for (std::size_t i = 0; i < row; ++i) {
        float sum = 0;
        for (int n = 0; n < at.count; ++n)
          sum += at.weight[n] * node[n * row + i];
        lines.push_back(sum);
      }
    }
  }
  return lines;
}

} // namespace

std::size_t DeformationNetwork::planeParameters() const {
  std::size_t at = 0;
  for (const Level& level : levels)
    at = planesOf(level, at).end;
  return at;
}

std::size_t DeformationNetwork::parameterCount() const {
  return layersOf(*this)[2].end();
}

void initialise(DeformationNetwork& network, std::uint64_t seed) {
  const auto [first, second, heads] = layersOf(network);
  network.parameters.assign(heads.end(), 0.f);
  Random random(seed);
  std::fill_n(network.parameters.begin(), first.at, 1.f);
  for (const Planes& planes : planesOf(network))
    for (std::size_t i = planes.space[0]; i < planes.time[0]; ++i)
      network.parameters[i] = static_cast<float>(0.5 + random.uniform());
  first.draw(network.parameters.data(), random);
  second.draw(network.parameters.data(), random);
}

void checkDeformation(const DeformationNetwork& network) {
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The dynamic model cannot be used: " + what);
  };
  if (network.levels.empty() || network.levels.size() > 4)
    fail("its deformation network has no levels or too many.");
  for (const auto& level : network.levels) {
    for (const int n : level.size)
      if (n < 2 || n > 1024) fail("a plane of its deformation network is out of range.");
    if (level.times < 4 || level.times > 4096) fail("a plane of its deformation network is out of range.");
  }
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(network.low[a]) || !std::isfinite(network.high[a]) ||
        !(network.high[a] > network.low[a]))
      fail("its deformation network has no extent in space.");
  if (!std::isfinite(network.start) || !std::isfinite(network.end) || !(network.end > network.start))
    fail("its deformation network has no extent in time.");
  if (network.parameters.size() != network.parameterCount())
    fail("its deformation network has another size than it says.");
  const auto finite = [](float v) { return std::fabs(v) <= 1e9f; };
  if (!std::all_of(network.parameters.begin(), network.parameters.end(), finite) ||
      !std::all_of(network.scale.begin(), network.scale.end(), finite))
    fail("its deformation network is not finite.");
}

void addPlaneSmoothness(const DeformationNetwork& network, double timeWeight, double spaceWeight,
                        std::span<float> gradient) {
  const float* p = network.parameters.data();
  const auto second = static_cast<float>(2 * timeWeight), first = static_cast<float>(2 * spaceWeight);
  const std::vector<Planes> planes = planesOf(network);
  for (std::size_t l = 0; l < planes.size(); ++l) {
    const auto& level = network.levels[l];
    for (int n = 0; n < 3; ++n) {
      const int nx = level.size[kPairs[n][0]], ny = level.size[kPairs[n][1]];
      const auto difference = [&](std::size_t a, std::size_t b) {
        const float d = first * (p[b] - p[a]);
        gradient[a] -= d;
        gradient[b] += d;
      };
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x)
          for (int c = 0; c < kC; ++c) {
            const std::size_t i = planes[l].space[n] + (static_cast<std::size_t>(y) * nx + x) * kC + c;
            if (x + 1 < nx) difference(i, i + kC);
            if (y + 1 < ny) difference(i, i + static_cast<std::size_t>(nx) * kC);
          }
    }
    for (int a = 0; a < 3; ++a) {
      const std::size_t row = static_cast<std::size_t>(level.size[a]) * kC;
      for (int t = 1; t + 1 < level.times; ++t)
        for (std::size_t i = 0; i < row; ++i) {
          const std::size_t at = planes[l].time[a] + t * row + i;
          const float d = second * (p[at - row] - 2 * p[at] + p[at + row]);
          gradient[at - row] += d;
          gradient[at] -= 2 * d;
          gradient[at + row] += d;
        }
    }
  }
}

struct DeformationEvaluator::Activations {
  explicit Activations(std::int64_t features)
      : encoded(kPointsPerBlock * features), first(kPointsPerBlock * kW), second(kPointsPerBlock * kW) {}
  std::vector<float> encoded, first, second;
};

DeformationEvaluator::DeformationEvaluator(const DeformationNetwork& network, std::span<const float> points,
                                           const NetworkKernels& kernels)
    : kernels_(kernels), points_(static_cast<std::int64_t>(points.size() / 3)) {
  places_.reserve(network.levels.size() * static_cast<std::size_t>(points_));
  for (const auto& level : network.levels)
    for (std::int64_t i = 0; i < points_; ++i) {
      std::array<Place, 3> place;
      for (int a = 0; a < 3; ++a) {
        const double x = std::clamp((static_cast<double>(points[3 * i + a]) - network.low[a]) /
                                        (network.high[a] - network.low[a]),
                                    0.0, 1.0) *
                         static_cast<double>(level.size[a] - 1);
        place[a].node = std::min(static_cast<int>(x), level.size[a] - 2);
        place[a].fraction = static_cast<float>(x - place[a].node);
      }
      places_.push_back(place);
    }
}

namespace {

/// The six factors of a level's features at a point, each a function of up to four nodes.
struct Taps {
  std::array<std::size_t, 4> node; // of a plane over space
  std::array<float, 4> weight;
};

template <class Place>
Taps tapsOf(const std::array<Place, 3>& place, int pair, std::size_t plane, int nx) {
  const Place &x = place[kPairs[pair][0]], &y = place[kPairs[pair][1]];
  const std::size_t at = plane + (static_cast<std::size_t>(y.node) * nx + x.node) * kC;
  return {{at, at + kC, at + static_cast<std::size_t>(nx) * kC, at + static_cast<std::size_t>(nx + 1) * kC},
          {(1 - x.fraction) * (1 - y.fraction), x.fraction * (1 - y.fraction), (1 - x.fraction) * y.fraction,
           x.fraction * y.fraction}};
}

using Factors = std::array<std::array<float, kC>, 6>; // three planes, three lines

template <class Place>
void factorsOf(const DeformationNetwork::Level& level, const Planes& planes, const float* parameters,
               const float* lines, const std::array<Place, 3>& place, Factors& out) {
  for (int n = 0; n < 3; ++n) {
    const Taps taps = tapsOf(place, n, planes.space[n], level.size[kPairs[n][0]]);
    for (int c = 0; c < kC; ++c)
      out[n][c] =
          taps.weight[0] * parameters[taps.node[0] + c] + taps.weight[1] * parameters[taps.node[1] + c] +
          taps.weight[2] * parameters[taps.node[2] + c] + taps.weight[3] * parameters[taps.node[3] + c];
  }
  for (int a = 0; a < 3; ++a) {
    const float* line = lines + static_cast<std::size_t>(place[a].node) * kC;
    for (int c = 0; c < kC; ++c)
      out[3 + a][c] = line[c] + place[a].fraction * (line[c + kC] - line[c]);
    lines += static_cast<std::size_t>(level.size[a]) * kC;
  }
}

std::size_t linesOf(const DeformationNetwork::Level& level) {
  return static_cast<std::size_t>(level.size[0] + level.size[1] + level.size[2]) * kC;
}

} // namespace

void DeformationEvaluator::encode(const DeformationNetwork& network, std::span<const float> lines,
                                  std::int64_t first, std::int64_t count, float* features) const {
  const std::vector<Planes> planes = planesOf(network);
  const std::int64_t stride = network.features();
  const float* levelLines = lines.data();
  Factors f;
  for (std::size_t l = 0; l < planes.size(); ++l) {
    for (std::int64_t i = 0; i < count; ++i) {
      factorsOf(network.levels[l], planes[l], network.parameters.data(), levelLines,
                places_[l * points_ + first + i], f);
      float* out = features + i * stride + static_cast<std::int64_t>(l) * kC;
      for (int c = 0; c < kC; ++c)
        out[c] = f[0][c] * f[1][c] * f[2][c] * f[3][c] * f[4][c] * f[5][c];
    }
    levelLines += linesOf(network.levels[l]);
  }
}

void DeformationEvaluator::hidden(const DeformationNetwork& network, std::span<const float> lines,
                                  std::int64_t first, std::int64_t count, Activations& work) const {
  const auto [toFirst, toSecond, heads] = layersOf(network);
  const float* p = network.parameters.data();
  encode(network, lines, first, count, work.encoded.data());
  toFirst.forward(p, work.encoded.data(), count, kernels_, work.first.data());
  toSecond.forward(p, work.first.data(), count, kernels_, work.second.data());
}

void DeformationEvaluator::forward(const DeformationNetwork& network, double time, std::span<float> out,
                                   ThreadPool& pool) const {
  const std::vector<float> lines = linesAt(network, time);
  const DenseLayer heads = layersOf(network)[2];
  pool.blocks(points_, kPointsPerBlock, [&](std::int64_t first, std::int64_t last) {
    Activations work(network.features());
    hidden(network, lines, first, last - first, work);
    float* to = out.data() + first * kO;
    heads.forward(network.parameters.data(), work.second.data(), last - first, kernels_, to);
    for (std::int64_t i = 0; i < (last - first) * kO; ++i)
      to[i] *= network.scale[i % kO];
  });
}

void DeformationEvaluator::backward(const DeformationNetwork& network, double time,
                                    std::span<const float> outputGradient, std::span<float> gradient,
                                    ThreadPool& pool) {
  const std::vector<float> lines = linesAt(network, time);
  const std::vector<Planes> planes = planesOf(network);
  const std::array<DenseLayer, 3> layers = layersOf(network);
  const DenseLayer &toFirst = layers[0], &toSecond = layers[1], &toHeads = layers[2];
  const float* p = network.parameters.data();
  const std::int64_t inputs = network.features();
  const std::vector<float> firstBack = toFirst.transposed(p), secondBack = toSecond.transposed(p),
                           headsBack = toHeads.transposed(p);
  chunkGradient_.resize(kChunks);
  chunkLineGradient_.resize(kChunks);
  pool.run(kChunks, [&](std::int64_t chunk) {
    std::vector<float>&g = chunkGradient_[chunk], &lineGradient = chunkLineGradient_[chunk];
    g.assign(network.parameters.size(), 0.f);
    lineGradient.assign(lines.size(), 0.f);
    Activations work(inputs);
    std::vector<float> heads(kPointsPerBlock * kO), second(kPointsPerBlock * kW), first(kPointsPerBlock * kW),
        encoded(kPointsPerBlock * inputs);
    const std::int64_t end = (chunk + 1) * points_ / kChunks;
    for (std::int64_t from = chunk * points_ / kChunks; from < end; from += kPointsPerBlock) {
      const std::int64_t n = std::min(kPointsPerBlock, end - from);
      hidden(network, lines, from, n, work);
      for (std::int64_t i = 0; i < n * kO; ++i)
        heads[i] = network.scale[i % kO] * outputGradient[from * kO + i];
      toHeads.backward(work.second.data(), nullptr, n, headsBack, kernels_, heads.data(), g.data(),
                       second.data());
      toSecond.backward(work.first.data(), work.second.data(), n, secondBack, kernels_, second.data(),
                        g.data(), first.data());
      toFirst.backward(work.encoded.data(), work.first.data(), n, firstBack, kernels_, first.data(), g.data(),
                       encoded.data());
      const float* levelLines = lines.data();
      float* levelLineGradient = lineGradient.data();
      Factors f;
      for (std::size_t level = 0; level < planes.size(); ++level) {
        const auto& shape = network.levels[level];
        for (std::int64_t i = 0; i < n; ++i) {
          const auto& place = places_[level * points_ + from + i];
          factorsOf(shape, planes[level], p, levelLines, place, f);
          const float* d = encoded.data() + i * inputs + static_cast<std::int64_t>(level) * kC;
          Factors others; // d times the product of the other five
          for (int c = 0; c < kC; ++c) {
            float before = d[c];
            for (int n6 = 0; n6 < 6; ++n6) {
              others[n6][c] = before;
              before *= f[n6][c];
            }
            float after = 1;
            for (int n6 = 5; n6 >= 0; --n6) {
              others[n6][c] *= after;
              after *= f[n6][c];
            }
          }
          for (int pair = 0; pair < 3; ++pair) {
            const Taps taps = tapsOf(place, pair, planes[level].space[pair], shape.size[kPairs[pair][0]]);
            for (int tap = 0; tap < 4; ++tap)
              for (int c = 0; c < kC; ++c)
                g[taps.node[tap] + c] += taps.weight[tap] * others[pair][c];
          }
          float* line = levelLineGradient;
          for (int a = 0; a < 3; ++a) {
            float* at = line + static_cast<std::size_t>(place[a].node) * kC;
            for (int c = 0; c < kC; ++c) {
              at[c] += (1 - place[a].fraction) * others[3 + a][c];
              at[c + kC] += place[a].fraction * others[3 + a][c];
            }
            line += static_cast<std::size_t>(shape.size[a]) * kC;
          }
        }
        levelLines += linesOf(shape);
        levelLineGradient += linesOf(shape);
      }
    }
  });
  const auto count = static_cast<std::int64_t>(gradient.size());
  pool.blocks(count, 8192, [&](std::int64_t from, std::int64_t to) {
    for (const auto& chunk : chunkGradient_)
      for (std::int64_t i = from; i < to; ++i)
        gradient[i] += chunk[i];
  });
  std::size_t at = 0;
  for (std::size_t level = 0; level < planes.size(); ++level) {
    const auto& shape = network.levels[level];
    const TimeSpline::Weights w = timeWeights(network, shape, time);
    for (int a = 0; a < 3; ++a) {
      const std::size_t row = static_cast<std::size_t>(shape.size[a]) * kC;
      float* to = gradient.data() + planes[level].time[a] + w.first * row;
      for (std::size_t i = 0; i < row; ++i, ++at) {
        float sum = 0;
        for (const auto& chunk : chunkLineGradient_)
          sum += chunk[at];
        for (int n = 0; n < w.count; ++n)
          to[n * row + i] += w.weight[n] * sum;
      }
    }
  }
}

} // namespace innergs
