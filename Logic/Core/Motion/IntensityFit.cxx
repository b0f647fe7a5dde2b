#include "Core/Motion/IntensityFit.h"

#include "Core/Motion/FrameFolds.h"
#include "Core/Render/GridRenderer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs {
namespace {

constexpr std::int64_t kPerTask = 4096;           // voxels or Gaussians
constexpr std::array<int, 3> kFiner{1, 2, 3};     // coefficients tried, times those of the plan
constexpr double kWorthwhile = 0.98;              // of the prediction error: below, more are worthwhile
constexpr std::int64_t kCoefficientSample = 2000; // voxels
constexpr std::int64_t kMostCoefficients = 256;
constexpr std::array<double, 12> kSmoothings{0.1, 0.3, 1, 3, 10, 30, 100, 300, 1e3, 1e4, 1e5, 1e6};

std::vector<double> later(std::vector<double> times, double by) {
  for (double& time : times)
    time += by;
  return times;
}

double dot(std::span<const float> a, std::span<const float> b, ThreadPool& pool) {
  const auto n = static_cast<std::int64_t>(a.size());
  std::vector<double> parts((n + kPerTask - 1) / kPerTask,
                            0.0); // summed in order, independent of the threads
  pool.blocks(n, kPerTask, [&](std::int64_t first, std::int64_t last) {
    double sum = 0;
    for (std::int64_t i = first; i < last; ++i)
      sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    parts[first / kPerTask] = sum;
  });
  double sum = 0;
  for (const double p : parts)
    sum += p;
  return sum;
}

/// Gaussian smoothing of a map along its three axes, with borders repeated.
void blur(std::vector<float>& map, const GridGeometry& g, double sigma, ThreadPool& pool) {
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<float> kernel(2 * radius + 1);
  float total = 0;
  for (int o = -radius; o <= radius; ++o)
    total += kernel[o + radius] = static_cast<float>(std::exp(-0.5 * o * o / (sigma * sigma)));
  std::vector<float> out(map.size());
  const std::int64_t step[3] = {1, g.size[0], g.size[0] * g.size[1]};
  for (int a = 0; a < 3; ++a) {
    pool.blocks(g.voxelCount(), kPerTask, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t v = first; v < last; ++v) {
        const std::int64_t at = v / step[a] % g.size[a];
        float sum = 0;
        for (int o = -radius; o <= radius; ++o)
          sum += kernel[o + radius] *
                 map[v + step[a] * (std::clamp<std::int64_t>(at + o, 0, g.size[a] - 1) - at)];
        out[v] = sum / total;
      }
    });
    map.swap(out);
  }
}

} // namespace

IntensityFit::IntensityFit(const TimeSeries& series, const IntensityMap& map, IntensityPlan plan,
                           const KernelSet& kernels, ThreadPool& pool)
    : series_(series), map_(map), plan_(plan), slices_(sliceGroups(series.sliceTiming, series.geometry)),
      kernels_(kernels), pool_(pool) {
  field_ = emptyField(DynamicKind::Intensity, series, map, plan.cutoff);
  const int most = std::min(plan.mostCoefficients, static_cast<int>(series.size()));
  const int wanted =
      static_cast<int>(std::lround(static_cast<double>(series.size()) / plan.framesPerCoefficient));
  field_.change = {series.times.front() + slices_.times.front(), series.times.back() + slices_.times.back(),
                   plan.coefficients > 0 ? plan.coefficients : std::max(4, std::min(most, wanted))};
  fillGaps();
  keepMean();
}

/// Interpolates non-finite values in time; a voxel without any finite value stays 0.
void IntensityFit::fillGaps() {
  course_.resize(series_.frames.size());
  const auto n = static_cast<std::int64_t>(series_.geometry.voxelCount());
  for (auto& frame : course_)
    frame.resize(n);
  const auto frames = static_cast<std::int64_t>(course_.size());
  const double inverse = 1 / map_.scale;
  pool_.blocks(n, kPerTask, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t v = first; v < last; ++v) {
      std::int64_t before = -1;
      for (std::int64_t f = 0; f < frames; ++f) {
        const float value = series_.frames[f][v];
        if (!std::isfinite(value)) continue;
        const auto now = static_cast<float>((static_cast<double>(value) - map_.offset) * inverse);
        for (std::int64_t gap = before + 1; gap < f; ++gap) {
          const double w = before < 0 ? 1
                                      : (series_.times[gap] - series_.times[before]) /
                                            (series_.times[f] - series_.times[before]);
          course_[gap][v] = before < 0
                                ? now
                                : static_cast<float>((1 - w) * static_cast<double>(course_[before][v]) +
                                                     w * static_cast<double>(now));
        }
        course_[f][v] = now;
        before = f;
      }
      for (std::int64_t gap = before + 1; gap < frames; ++gap)
        course_[gap][v] = before < 0 ? 0 : course_[before][v];
    }
  });
}

void IntensityFit::keepMean() {
  Volume& mean = field_.canonical.residual;
  mean.geometry = series_.geometry;
  mean.voxels.resize(static_cast<std::size_t>(series_.geometry.voxelCount()));
  pool_.blocks(series_.geometry.voxelCount(), kPerTask, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t v = first; v < last; ++v) {
      double sum = 0;
      for (const auto& frame : course_)
        sum += static_cast<double>(frame[v]);
      mean.voxels[v] = static_cast<float>(sum / static_cast<double>(course_.size()));
      for (auto& frame : course_)
        frame[v] -= mean.voxels[v];
    }
  });
}

void IntensityFit::chooseCoefficients() {
  const std::int64_t n = series_.geometry.voxelCount(),
                     step = std::max<std::int64_t>(1, n / kCoefficientSample);
  const std::int64_t most = std::min<std::int64_t>(kMostCoefficients, series_.size());
  const std::vector<FrameFold> folds = frameFolds(series_.times);
  // The mean squared error at held-out frames with the best of the smoothings, of the same slice times.
  const auto error = [&](const TimeSpline& spline) {
    std::array<double, kSmoothings.size()> sums{};
    pool_.blocks(std::ssize(kSmoothings), 1, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t s = first; s < last; ++s)
        for (const FrameFold& fold : folds) {
          const double delay = slices_.times.front();
          const auto rows = splinePrediction(spline, later(fold.keptTimes, delay),
                                             later(fold.heldOutTimes, delay), kSmoothings[s]);
          for (std::int64_t v = 0; v < n; v += step)
            for (std::size_t i = 0; i < fold.heldOut.size(); ++i) {
              double predicted = 0;
              for (std::size_t t = 0; t < fold.kept.size(); ++t)
                predicted += rows[i * fold.kept.size() + t] * static_cast<double>(course_[fold.kept[t]][v]);
              sums[s] += std::pow(predicted - static_cast<double>(course_[fold.heldOut[i]][v]), 2);
            }
        }
    });
    return *std::min_element(sums.begin(), sums.end());
  };
  const int planned = field_.change.coefficients;
  double least = 0;
  for (const int finer : kFiner) {
    pool_.throwIfStopped();
    TimeSpline spline = field_.change;
    spline.coefficients = static_cast<int>(std::min<std::int64_t>(most, std::int64_t{finer} * planned));
    const double found = error(spline);
    if (finer == 1 || found < kWorthwhile * least) {
      least = found;
      field_.change = spline;
    }
  }
}

void IntensityFit::choose(const Report& report) {
  if (plan_.coefficients == 0) chooseCoefficients();
  const std::int64_t n = series_.geometry.voxelCount();
  std::vector<std::vector<float>> errors(kSmoothings.size(), std::vector<float>(n, 0.f));
  frameErrors_.assign(kSmoothings.size(), std::vector<double>(course_.size(), 0.0));
  const std::vector<FrameFold> folds = frameFolds(series_.times);
  for (std::size_t fold = 0; fold < folds.size(); ++fold) {
    const std::vector<std::int64_t>&kept = folds[fold].kept, &heldOut = folds[fold].heldOut;
    for (std::size_t s = 0; s < kSmoothings.size(); ++s) {
      pool_.throwIfStopped();
      std::vector<std::vector<double>> rows; // of each group of slices
      for (const double time : slices_.times)
        rows.push_back(splinePrediction(field_.change, later(folds[fold].keptTimes, time),
                                        later(folds[fold].heldOutTimes, time), kSmoothings[s]));
      const std::int64_t blocks = (n + kPerTask - 1) / kPerTask;
      std::vector<double> parts(blocks * heldOut.size(), 0.0);
      pool_.blocks(n, kPerTask, [&](std::int64_t first, std::int64_t last) {
        std::vector<float> predicted(static_cast<std::size_t>(last - first));
        for (std::size_t i = 0; i < heldOut.size(); ++i) {
          std::fill(predicted.begin(), predicted.end(), 0.f);
          slices_.runs(first, last, [&](std::int64_t begin, std::int64_t end, int group) {
            for (std::size_t t = 0; t < kept.size(); ++t) {
              const auto w = static_cast<float>(rows[group][i * kept.size() + t]);
              const float* in = course_[kept[t]].data();
              for (std::int64_t v = begin; v < end; ++v)
                predicted[v - first] += w * in[v];
            }
          });
          const float* truth = course_[heldOut[i]].data() + first;
          double sum = 0;
          for (std::size_t v = 0; v < predicted.size(); ++v) {
            const float e = (predicted[v] - truth[v]) * (predicted[v] - truth[v]);
            errors[s][first + v] += e;
            sum += static_cast<double>(e);
          }
          parts[first / kPerTask * heldOut.size() + i] = sum;
        }
      });
      for (std::size_t part = 0; part < parts.size(); ++part)
        frameErrors_[s][heldOut[part % heldOut.size()]] += parts[part] / static_cast<double>(n);
      report((static_cast<double>(fold) + static_cast<double>(s + 1) / kSmoothings.size()) /
             static_cast<double>(folds.size()));
    }
  }
  std::vector<float> least(n);
  chosen_.assign(n, static_cast<std::uint8_t>(kSmoothings.size() - 1));
  for (std::size_t s = 0; s < kSmoothings.size(); ++s) {
    std::vector<float> shared = errors[s];
    blur(shared, series_.geometry, plan_.neighbourhood, pool_);
    for (std::int64_t v = 0; v < n; ++v)
      if (s == 0 || shared[v] < least[v]) {
        least[v] = shared[v];
        chosen_[v] = static_cast<std::uint8_t>(s);
      }
  }
}

double IntensityFit::predictionError(std::int64_t frame) const {
  std::size_t best = 0; // smoothing, over all frames
  double least = -1;
  for (std::size_t s = 0; s < frameErrors_.size(); ++s) {
    double sum = 0;
    for (const double e : frameErrors_[s])
      sum += e;
    if (least >= 0 && sum >= least) continue;
    least = sum;
    best = s;
  }
  return frameErrors_[best][frame];
}

void IntensityFit::solve(const Report& report) {
  const GridGeometry& g = series_.geometry;
  GaussianField& field = field_.canonical;
  const Affine3 toModel = inverse(field.modelToWorld) * g.indexToWorld();
  const double distance = std::cbrt(plan_.voxelsPerGaussian); // voxels
  std::array<std::int64_t, 3> count;
  Gaussian shape{};
  shape.quaternion[0] = 1;
  for (int a = 0; a < 3; ++a) {
    count[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(g.size[a]) / distance));
    shape.logScale[a] = static_cast<float>(std::log(
        plan_.width * g.spacing[a] * static_cast<double>(g.size[a]) / static_cast<double>(count[a])));
  }
  field.gaussians.clear();
  for (std::int64_t k = 0; k < count[2]; ++k)
    for (std::int64_t j = 0; j < count[1]; ++j)
      for (std::int64_t i = 0; i < count[0]; ++i) {
        const std::int64_t at[3] = {i, j, k};
        Vec3 index;
        for (int a = 0; a < 3; ++a)
          index[a] = (static_cast<double>(at[a]) + 0.5) * static_cast<double>(g.size[a]) /
                         static_cast<double>(count[a]) -
                     0.5;
        const Vec3 mean = toModel(index);
        for (int a = 0; a < 3; ++a)
          shape.mean[a] = static_cast<float>(mean[a]);
        field.gaussians.push_back(shape);
      }
  const std::size_t gaussians = field.gaussians.size();

  const SampleGrid grid = sampleGridOf(g, field.modelToWorld);
  GridRenderer renderer(grid, kernels_, pool_);
  const std::size_t size = grid.bufferSize();
  std::vector<float> weights(size), image(size), zero(size, 0.f), gradient(16 * gaussians);
  const auto epsilon = static_cast<float>(field.epsilon);
  const auto rows = static_cast<std::int64_t>(g.size[1] * g.size[2]);
  const std::int64_t nx = g.size[0];
  // image = A·values, in rows of the grid.
  const auto forward = [&](std::span<const float> values) {
    renderer.forward(field, values, weights.data(), image.data());
    pool_.blocks(rows, 64, [&](std::int64_t first, std::int64_t last) {
      for (std::size_t i = first * grid.stride(); i < static_cast<std::size_t>(last) * grid.stride(); ++i)
        image[i] /= weights[i] + epsilon;
    });
  };
  // out = Aᵀ·(target − image), or of −image without a target; uses image up.
  const auto transposed = [&](const float* target, std::vector<float>& out) {
    pool_.blocks(rows, 64, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t row = first; row < last; ++row)
        for (std::int64_t x = 0; x < grid.stride(); ++x) {
          const std::size_t i = row * grid.stride() + x;
          const float wanted = target && x < nx ? target[row * nx + x] : 0.f;
          image[i] = x < nx ? (wanted - image[i]) / (weights[i] + epsilon) : 0.f;
        }
    });
    std::fill(gradient.begin(), gradient.end(), 0.f);
    renderer.backward(field, image.data(), zero.data(), gradient);
    pool_.blocks(static_cast<std::int64_t>(gaussians), kPerTask, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t i = first; i < last; ++i)
        out[i] = gradient[16 * i + 11];
    });
  };

  std::array<std::vector<std::vector<double>>, kSmoothings.size()> fits; // [smoothing][group of slices]
  for (std::size_t s = 0; s < kSmoothings.size(); ++s)
    for (const double time : slices_.times) {
      pool_.throwIfStopped();
      fits[s].push_back(splineFit(field_.change, later(series_.times, time), kSmoothings[s]));
    }
  const std::size_t frames = course_.size();
  std::vector<float> target(static_cast<std::size_t>(g.voxelCount())), values(gaussians), r(gaussians),
      p(gaussians), q(gaussians);
  field_.changes.assign(gaussians * field_.change.coefficients, 0.f);
  const auto ridge = static_cast<float>(plan_.ridge);
  for (int c = 0; c < field_.change.coefficients; ++c) {
    pool_.blocks(g.voxelCount(), kPerTask, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t v = first; v < last; ++v) {
        const double* row = fits[chosen_[v]][slices_.of(v)].data() + c * frames;
        double sum = 0;
        for (std::size_t f = 0; f < frames; ++f)
          sum += row[f] * static_cast<double>(course_[f][v]);
        target[v] = static_cast<float>(sum);
      }
    });
    std::fill(values.begin(), values.end(), 0.f);
    forward(values);
    transposed(target.data(), r);
    p = r;
    double rr = dot(r, r, pool_);
    const double enough = 1e-10 * rr;
    for (int i = 0; i < plan_.iterations && rr > enough; ++i) {
      pool_.throwIfStopped();
      forward(p);
      transposed(nullptr, q); // −AᵀA·p
      for (std::size_t n = 0; n < gaussians; ++n)
        q[n] = ridge * p[n] - q[n];
      const double alpha = rr / dot(p, q, pool_);
      for (std::size_t n = 0; n < gaussians; ++n) {
        values[n] += static_cast<float>(alpha) * p[n];
        r[n] -= static_cast<float>(alpha) * q[n];
      }
      const double next = dot(r, r, pool_), beta = next / rr;
      rr = next;
      for (std::size_t n = 0; n < gaussians; ++n)
        p[n] = r[n] + static_cast<float>(beta) * p[n];
    }
    std::copy(values.begin(), values.end(),
              field_.changes.begin() + static_cast<std::ptrdiff_t>(gaussians) * c);
    report(static_cast<double>(c + 1) / field_.change.coefficients);
  }
}

} // namespace innergs
