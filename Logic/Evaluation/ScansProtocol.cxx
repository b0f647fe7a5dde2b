#include "Evaluation/ScansProtocol.h"

#include "Core/Alignment/SliceOperator.h"
#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Job/JobInput.h"
#include "Core/Render/Render.h"
#include "Evaluation/Baselines.h"
#include "Evaluation/EvaluationRuns.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kFewest = 50; // pixels of a scored slice

using Slices = std::vector<std::vector<std::int64_t>>; // per scan

/// The scans with their held-out slices interpolated from the four nearest others.
std::vector<Stack> bridged(std::vector<Stack> scans, const Slices& heldOut) {
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const auto& n = scans[s].image.geometry.size;
    std::vector<float>& voxels = scans[s].image.voxels;
    const std::int64_t plane = n[0] * n[1];
    for (const std::int64_t k : heldOut[s]) {
      const std::int64_t before = std::max<std::int64_t>(0, k - 2), after = std::min(n[2] - 1, k + 2);
      for (std::int64_t p = 0; p < plane; ++p)
        voxels[k * plane + p] = (9 * (voxels[(k - 1) * plane + p] + voxels[(k + 1) * plane + p]) -
                                 (voxels[before * plane + p] + voxels[after * plane + p])) /
                                16;
    }
  }
  return scans;
}

struct Method {
  std::string name;
  std::vector<Stack> placed; // the whole scans, where the method puts them
  std::function<Volume(const GridGeometry&)> render;
};

/// What the method shows of each held-out slice; NaN: nothing.
std::vector<std::vector<float>> predictions(const Method& method, const PreparedInput& prepared,
                                            const GridGeometry& grid, ThreadPool& pool) {
  const SliceOperator op(grid, pool);
  const std::vector<float> volume = method.render(grid).voxels;
  std::vector<std::vector<float>> seen;
  for (std::size_t s = 0; s < method.placed.size(); ++s) {
    const auto& heldOut = prepared.heldOut[s];
    Stack stack = method.placed[s];
    stack.observed = prepared.scored[s];
    const std::vector<SlicePose> poses =
        placeSlices(method.render, stack, heldOut, prepared.range.low >= 0, pool);
    stack.poses.assign(static_cast<std::size_t>(stack.image.geometry.size[2]), Affine3{});
    for (std::size_t n = 0; n < heldOut.size(); ++n)
      stack.poses[static_cast<std::size_t>(heldOut[n])] = poses[n].pose;
    const std::vector<PlacedSlice> slices = placedSlices(
        stack, s, 1, profileQuadrature(stack.profile, effectiveThickness(stack), grid.spacing[0]));
    for (const std::int64_t k : heldOut)
      seen.push_back(op.project(volume, slices[static_cast<std::size_t>(k)]));
  }
  return seen;
}

/// Sums over the pixels of a slice.
struct Moments {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  void add(double a, double b) {
    ++count;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
    yy += b * b;
  }
  double correlation() const {
    const double both = count * xy - x * y, own = (count * xx - x * x) * (count * yy - y * y);
    return own > 0 ? both / std::sqrt(own) : 0;
  }
  /// Of y to x with the best gain.
  double squaredError() const { return xx > 0 ? yy - xy * xy / xx : yy; }
};

} // namespace

EvaluationReport evaluateScans(const std::vector<Stack>& scans, const std::vector<Mask>& masks,
                               const EvaluationOptions& options) {
  if (scans.size() < 2)
    throw Error(ErrorCode::InvalidArgument, "Held-out slices of real scans need two scans or more.");
  if (!(options.heldOutFraction > 0 && options.heldOutFraction <= 1.0 / 3))
    throw Error(ErrorCode::InvalidArgument, "The held-out fraction of real scans must be above 0 and at most "
                                            "a third: neighbours of held-out slices must be left.");
  ThreadPool pool(options.settings.threads);
  pool.setStop(options.stop);
  ReconstructionInput input;
  input.stacks = scans;
  input.masks = masks;
  input.heldOutFraction = options.heldOutFraction;
  const PreparedInput prepared = prepareInput(input, options.stop, true);
  input.heldOutFraction = 0;
  for (std::size_t s = 0; s < scans.size(); ++s)
    input.stacks[s].observed = prepared.stacks[s].observed;

  EvaluationReport report;
  report.protocol = "scans";
  report.caseName = formatted("scans-%zu-withheld-%g%%", scans.size(), 100 * options.heldOutFraction);
  report.peak = prepared.range.high - prepared.range.low;
  report.range = formatted("PSNR peak: the scans' maximum minus minimum, %g.", report.peak);

  // Needed for the alignment, whatever is scored.
  ReconstructionResult result;
  const TimedVolume fit = runMethod("gaussians", options, [&] {
    ReconstructionJob job(std::move(input), options.settings);
    if (options.progress) job.onProgress(options.progress);
    result = job.run(options.stop);
    if (result.cancelled) throw Error(ErrorCode::Cancelled, "The evaluation was cancelled.");
    return std::move(result.volume);
  });
  report.densified = result.densified;
  report.notes = result.warnings;
  if (options.keepVolumes) report.model = result.model;
  GaussianField field = result.model->field;
  field.fill = std::numeric_limits<double>::quiet_NaN();
  const GridGeometry fitted = field.support.voxels.empty() ? field.domain : field.support.geometry;
  std::vector<Stack> aligned = scans;
  if (!result.alignment.empty()) applyAlignment(result.alignment, aligned);
  const auto average = [&](const std::vector<Stack>& stacks) {
    return [&, filled = bridged(stacks, prepared.heldOut)](const GridGeometry& grid) {
      return averageUpsampled(filled, grid, Interpolation::Cubic, options.settings.threads, options.stop);
    };
  };
  RenderOptions rendering;
  rendering.threads = options.settings.threads;
  rendering.instructionSet = result.settings.instructionSet;
  rendering.stop = options.stop;
  const std::vector<Method> methods{
      {"gaussians", aligned, [&](const GridGeometry& grid) { return render(field, grid, rendering); }},
      {"average", scans, average(scans)},
      {"aligned average", aligned, average(aligned)}};
  std::vector<std::vector<std::vector<float>>> seen;
  for (const Method& method : methods) {
    const auto begun = std::chrono::steady_clock::now();
    if (options.onMethod && seen.size() > 0) options.onMethod(method.name);
    seen.push_back(predictions(method, prepared, fitted, pool));
    MethodScore& score = report.methods.emplace_back();
    score.name = method.name;
    score.ssim = std::numeric_limits<double>::quiet_NaN();
    score.seconds = secondsSince(begun);
  }
  report.methods.front().seconds += fit.seconds;
  report.methods.front().cpuSeconds = fit.cpuSeconds;
  report.methods.front().peakMemory = fit.peakMemory;
  if (options.keepVolumes) report.methods.front().volume = fit.volume;

  std::vector<double> squared(methods.size()), correlation(methods.size());
  std::int64_t slices = 0;
  std::size_t slice = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const auto& n = scans[s].image.geometry.size;
    const std::int64_t plane = n[0] * n[1];
    for (const std::int64_t k : prepared.heldOut[s]) {
      std::vector<Moments> moments(methods.size());
      for (std::int64_t p = 0; p < plane; ++p) {
        const auto v = static_cast<std::size_t>(k * plane + p);
        const auto known = [&](const auto& of) {
          return std::isfinite(of[slice][static_cast<std::size_t>(p)]);
        };
        if (!std::isfinite(scans[s].image.voxels[v]) ||
            (!prepared.scored[s].empty() && !prepared.scored[s][v]) ||
            !std::all_of(seen.begin(), seen.end(), known))
          continue;
        for (std::size_t m = 0; m < methods.size(); ++m)
          moments[m].add(seen[m][slice][static_cast<std::size_t>(p)], scans[s].image.voxels[v]);
      }
      ++slice;
      if (moments.front().count < kFewest) continue;
      ++slices;
      report.voxels += static_cast<std::int64_t>(moments.front().count);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        squared[m] += moments[m].squaredError();
        correlation[m] += moments[m].correlation();
      }
    }
  }
  if (slices == 0)
    throw Error(ErrorCode::NoData,
                "No held-out slice shows enough to be scored: give larger scans or masks.");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    MethodScore& score = report.methods[m];
    score.psnr = score.pooledPsnr =
        10 * std::log10(report.peak * report.peak * static_cast<double>(report.voxels) / squared[m]);
    score.ncc = correlation[m] / static_cast<double>(slices);
  }
  report.samples = formatted(
      "%s voxels of %s held-out slices%s, that all methods predict; each slice was registered to each "
      "method's volume, in which it took no part, and one gain per slice was removed.",
      countText(report.voxels).c_str(), countText(slices).c_str(), masks.empty() ? "" : " inside the masks");
  return report;
}

} // namespace innergs
