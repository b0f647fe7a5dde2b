#include "Evaluation/FrameInterpolation.h"

#include "Core/Base/Error.h"
#include "Core/Base/Parallel.h"
#include "Core/Base/StopToken.h"
#include "Core/Motion/FrameFolds.h"
#include "Core/Motion/TimeSpline.h"

#include <itkImage.h>
#include <itkMultiResolutionPDEDeformableRegistration.h>
#include <itkSymmetricForcesDemonsRegistrationFilter.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs {
namespace {

constexpr std::int64_t kBlock = 4096;

/// The last frame at or before a time that has a successor.
std::int64_t frameBefore(const TimeSeries& series, double time) {
  const auto after = std::upper_bound(series.times.begin(), series.times.end(), time);
  return std::clamp<std::int64_t>(after - series.times.begin() - 1, 0, series.size() - 2);
}

double shareOfWay(const TimeSeries& series, std::int64_t before, double time) {
  return std::clamp((time - series.times[before]) / (series.times[before + 1] - series.times[before]), 0.0,
                    1.0);
}

/// Weights of the frames at one time in their natural cubic spline: second derivatives from the tridiagonal
/// system, solved for every unit vector.
std::vector<double> cubicWeights(const std::vector<double>& t, double time) {
  const std::size_t n = t.size();
  std::vector<double> weights(n);
  for (std::size_t unit = 0; unit < n; ++unit) {
    std::vector<double> y(n, 0.0), m(n, 0.0), diagonal(n, 1.0), upper(n, 0.0), right(n, 0.0);
    y[unit] = 1;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
      const double lower = h0 / (h0 + h1),
                   r = 6 * ((y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0) / (h0 + h1);
      const double pivot = 2 - lower * upper[i - 1];
      diagonal[i] = pivot;
      upper[i] = (1 - lower) / pivot;
      right[i] = (r - lower * right[i - 1]) / pivot;
    }
    for (std::size_t i = n - 1; i-- > 1;)
      m[i] = right[i] - upper[i] * m[i + 1];
    const auto after = std::upper_bound(t.begin(), t.end(), time);
    const auto i = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(after - t.begin() - 1, 0, static_cast<std::ptrdiff_t>(n) - 2));
    const double h = t[i + 1] - t[i], a = (t[i + 1] - time) / h, b = (time - t[i]) / h;
    weights[unit] =
        a * y[i] + b * y[i + 1] + ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]) * h * h / 6;
  }
  return weights;
}

std::vector<std::vector<float>> combined(const TimeSeries& series, const std::vector<double>& rows,
                                         std::size_t count, ThreadPool& pool) {
  const std::size_t frames = series.frames.size();
  std::vector<std::vector<float>> out(
      count, std::vector<float>(static_cast<std::size_t>(series.geometry.voxelCount()), 0.f));
  pool.blocks(series.geometry.voxelCount(), kBlock, [&](std::int64_t first, std::int64_t last) {
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t f = 0; f < frames; ++f) {
        const auto w = static_cast<float>(rows[i * frames + f]);
        if (w == 0) continue;
        for (std::int64_t v = first; v < last; ++v)
          out[i][v] += w * series.frames[f][v];
      }
  });
  return out;
}

/// A smoothing spline per voxel; its smoothing is the one that best predicts every 4th frame from the others,
/// for each of the four offsets.
std::vector<std::vector<float>> smoothed(const TimeSeries& series, std::span<const double> times,
                                         ThreadPool& pool) {
  const TimeSpline spline{series.times.front(), series.times.back(),
                          std::max(4, static_cast<int>(series.size()))};
  const auto voxels = static_cast<std::size_t>(series.geometry.voxelCount());
  std::vector<float> least(voxels);
  std::vector<std::vector<float>> out;
  for (double smoothing = 0.1; smoothing < 2e6; smoothing *= std::sqrt(10.0)) {
    std::vector<float> errors(voxels, 0.f);
    for (const FrameFold& fold : frameFolds(series.times)) {
      const auto predicted = combined(framesOf(series, fold.kept),
                                      splinePrediction(spline, fold.keptTimes, fold.heldOutTimes, smoothing),
                                      fold.heldOut.size(), pool);
      for (std::size_t i = 0; i < fold.heldOut.size(); ++i)
        for (std::size_t v = 0; v < voxels; ++v) {
          const float d = predicted[i][v] - series.frames[fold.heldOut[i]][v];
          if (std::isfinite(d)) errors[v] += d * d;
        }
    }
    const auto candidate =
        combined(series, splinePrediction(spline, series.times, times, smoothing), times.size(), pool);
    if (out.empty()) {
      out = candidate;
      least = errors;
      continue;
    }
    for (std::size_t v = 0; v < voxels; ++v) {
      if (!(errors[v] < least[v])) continue;
      least[v] = errors[v];
      for (std::size_t i = 0; i < times.size(); ++i)
        out[i][v] = candidate[i][v];
    }
  }
  return out;
}

using Image = itk::Image<float, 3>;
using Field = itk::Image<itk::Vector<float, 3>, 3>;

/// Nearly cubic voxels are treated as cubes by the registration; other voxels keep their proportions.
Image::Pointer image(const GridGeometry& g, const std::vector<float>& voxels, double scale) {
  auto out = Image::New();
  Image::RegionType region;
  Image::SpacingType spacing;
  for (unsigned a = 0; a < 3; ++a) {
    region.SetSize(a, static_cast<itk::SizeValueType>(g.size[a]));
    spacing[a] = g.spacing[a];
  }
  out->SetRegions(region);
  out->SetSpacing(spacing);
  out->Allocate();
  for (std::size_t v = 0; v < voxels.size(); ++v)
    out->GetBufferPointer()[v] = std::isfinite(voxels[v]) ? static_cast<float>(voxels[v] * scale) : 0.f;
  return out;
}

} // namespace

const char* frameMethodName(FrameMethod method) {
  constexpr std::array names{"previous frame", "nearest frame", "linear in time",
                             "cubic in time",  "temporal mean", "voxel smoothing spline"};
  return names.at(static_cast<std::size_t>(method));
}

std::vector<std::vector<float>> interpolateFrames(const TimeSeries& series, std::span<const double> times,
                                                  FrameMethod method, int threads,
                                                  const std::stop_token& stop) {
  ThreadPool pool(threads);
  pool.setStop(stop);
  const std::size_t frames = series.frames.size();
  if (method == FrameMethod::Spline) return smoothed(series, times, pool);
  std::vector<double> rows(times.size() * frames, 0.0);
  for (std::size_t i = 0; i < times.size(); ++i) {
    double* row = rows.data() + i * frames;
    const std::int64_t before = frameBefore(series, times[i]);
    const double w = shareOfWay(series, before, times[i]);
    if (method == FrameMethod::Previous)
      row[w < 1 ? before : before + 1] = 1;
    else if (method == FrameMethod::Nearest)
      row[w <= 0.5 ? before : before + 1] = 1;
    else if (method == FrameMethod::Linear)
      row[before] = 1 - w, row[before + 1] = w;
    else if (method == FrameMethod::Mean)
      std::fill_n(row, frames, 1.0 / static_cast<double>(frames));
    else
      std::ranges::copy(cubicWeights(series.times, times[i]), row);
  }
  return combined(series, rows, times.size(), pool);
}

std::vector<float> demonsFrame(const TimeSeries& series, double time, const std::stop_token& stop) {
  throwIfStopped(stop);
  const std::int64_t before = frameBefore(series, time);
  const double w = shareOfWay(series, before, time);
  const GridGeometry& g = series.geometry;
  const ValueRange range = rangeOf(series);
  const double scale =
      1000 / std::max(1e-30, static_cast<double>(range.high) - static_cast<double>(range.low));
  const std::vector<float>&a = series.frames[before], &b = series.frames[before + 1];
  using Demons = itk::SymmetricForcesDemonsRegistrationFilter<Image, Image, Field>;
  using Pyramid = itk::MultiResolutionPDEDeformableRegistration<Image, Image, Field>;
  const auto demons = Demons::New();
  demons->SetStandardDeviations(3); // voxels; the best of 1 to 3 on the simulated wrist
  demons->SetSmoothDisplacementField(true);
  const auto pyramid = Pyramid::New();
  pyramid->SetRegistrationFilter(demons);
  pyramid->SetNumberOfLevels(3);
  pyramid->SetFixedImage(image(g, a, scale));
  pyramid->SetMovingImage(image(g, b, scale));
  // Does not shrink the few slices.
  itk::Array2D<unsigned int> schedule(3, 3);
  for (unsigned level = 0; level < 3; ++level) {
    schedule[level][0] = schedule[level][1] = 4 >> level;
    schedule[level][2] = 1;
  }
  pyramid->GetModifiableFixedImagePyramid()->SetSchedule(schedule);
  pyramid->GetModifiableMovingImagePyramid()->SetSchedule(schedule);
  std::array<unsigned int, 3> iterations{80, 80, 60};
  pyramid->SetNumberOfIterations(iterations.data());
  try {
    pyramid->Update();
  } catch (const itk::ExceptionObject& error) {
    throw Error(ErrorCode::Internal,
                std::string("The demons registration failed: ") + error.GetDescription());
  }
  const Field* field = pyramid->GetOutput();
  std::array<Volume, 3> u; // displacement from a frame's voxels to their positions in the next frame, voxels
  for (int axis = 0; axis < 3; ++axis) {
    u[axis].geometry = g;
    u[axis].voxels.resize(a.size());
    for (std::size_t v = 0; v < a.size(); ++v)
      u[axis].voxels[v] = static_cast<float>(
          static_cast<double>(field->GetBufferPointer()[v][static_cast<unsigned>(axis)]) / g.spacing[axis]);
  }
  const Volume first{g, a}, second{g, b};
  std::vector<float> out;
  out.reserve(a.size());
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vec3 x{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        Vec3 from = x, way{0, 0, 0}; // the voxel now at x came from there
        for (int step = 0; step < 4; ++step) {
          for (int axis = 0; axis < 3; ++axis)
            way[axis] = static_cast<double>(sampleLinear(u[axis], from));
          from = x - w * way;
        }
        out.push_back(static_cast<float>((1 - w) * static_cast<double>(sampleLinear(first, from)) +
                                         w * static_cast<double>(sampleLinear(second, from + way))));
      }
  return out;
}

} // namespace innergs
