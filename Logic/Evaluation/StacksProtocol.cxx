#include "Evaluation/StacksProtocol.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Base/Cholesky.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Image/BodyMask.h"
#include "Core/Render/Render.h"
#include "Evaluation/BackProjectionBaseline.h"
#include "Evaluation/Baselines.h"
#include "Evaluation/EvaluationRuns.h"
#include "Evaluation/IntervalScore.h"
#include "Evaluation/ItkInterpolation.h"
#include "IO/N4Correction.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr double kFromFaces = 8; // mm that are not scored

std::string caseName(const StacksCase& c) {
  std::string name = formatted("stacks-%d-thick-%gmm", c.stacks, c.thickness);
  const auto add = [&](const char* what, double value) {
    if (value > 0) name += formatted(what, value);
  };
  add("-gap-%gmm", c.gap);
  for (const double pixel : c.pixels)
    add("-pixels-%gmm", pixel);
  if (c.interpolated) name += "-interpolated";
  add("-motion-%gmm", c.motion);
  add("-turn-%gdeg", c.turn);
  add("-motion-packets-%g", c.motionPackets);
  add("-shading-%g", c.shading);
  add("-gain-%g", c.gain);
  add("-noise-%g", c.noise);
  return name;
}

/// The truth's body, except near the faces of the box.
std::vector<std::uint8_t> scoredMask(const Volume& truth, const std::vector<std::uint8_t>& body) {
  std::vector<std::uint8_t> mask = body;
  const auto& n = truth.geometry.size;
  for (std::int64_t v = 0; v < truth.geometry.voxelCount(); ++v) {
    const std::int64_t at[3] = {v % n[0], v / n[0] % n[1], v / (n[0] * n[1])};
    for (int a = 0; a < 3; ++a) {
      const double face =
          (static_cast<double>(std::min(at[a], n[a] - 1 - at[a])) + 0.5) * truth.geometry.spacing[a];
      if (face < kFromFaces) mask[static_cast<std::size_t>(v)] = 0;
    }
  }
  if (std::find(mask.begin(), mask.end(), 1) == mask.end())
    throw Error(ErrorCode::NoData,
                "The volume shows no body 8 mm or more from its faces: give a larger one.");
  return mask;
}

/// The rigid transform of places in the truth to places in the image, by Gauss-Newton on their difference.
Affine3 registered(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask) {
  constexpr std::size_t every = 7;
  const Affine3 map = truth.geometry.indexToWorld(), toImage = inverse(image.geometry.indexToWorld());
  const auto& n = truth.geometry.size;
  const Vec3 centre = truth.geometry.centre();
  const double step = 0.5 * truth.geometry.spacing[0];
  Affine3 found;
  double gain = 1;
  for (int iteration = 0; iteration < 40; ++iteration) {
    std::vector<double> square(49), right(7);
    for (std::size_t v = 0; v < mask.size(); v += every) {
      if (!mask[v]) continue;
      const auto at = static_cast<std::int64_t>(v);
      const Vec3 x = found(map({static_cast<double>(at % n[0]), static_cast<double>(at / n[0] % n[1]),
                                static_cast<double>(at / (n[0] * n[1]))}));
      const double own = sampleLinear(image, toImage(x)), r = truth.voxels[v] - gain * own;
      Vec3 slope;
      for (int a = 0; a < 3; ++a) {
        Vec3 low = x, high = x;
        low[a] -= step;
        high[a] += step;
        slope[a] =
            gain * (sampleLinear(image, toImage(high)) - sampleLinear(image, toImage(low))) / (2 * step);
      }
      const Vec3 turn = cross(x - centre, slope);
      const double j[7] = {slope[0], slope[1], slope[2], turn[0], turn[1], turn[2], own};
      for (int a = 0; a < 7; ++a) {
        for (int b = 0; b < 7; ++b)
          square[a * 7 + b] += j[a] * j[b];
        right[a] += j[a] * r;
      }
    }
    for (int a = 0; a < 7; ++a)
      square[a * 8] = square[a * 8] > 0 ? square[a * 8] * (1 + 1e-9) : 1;
    solveCholesky(square, right, 7, 1);
    const Vec3 shift{right[0], right[1], right[2]}, turn{right[3], right[4], right[5]};
    found = rigidAbout(centre, turn, shift) * found;
    gain += right[6];
    if (norm(shift) < 1e-4 && norm(turn) < 1e-6) break;
  }
  return found;
}

GridGeometry moved(GridGeometry grid, const Affine3& motion) {
  grid.origin = motion(grid.origin);
  grid.direction = motion.linear * grid.direction;
  return grid;
}

/// The image moved onto the truth's grid.
Volume moved(const Volume& image, const Volume& truth, const Affine3& toImage, ThreadPool& pool) {
  return {truth.geometry, ItkCubic(image).on(moved(truth.geometry, toImage), pool)};
}

/// Multiplied by the one gain that brings it nearest to the truth.
void scaleTo(Volume& image, const Volume& truth, std::span<const std::uint8_t> mask) {
  double own = 0, both = 0;
  for (std::size_t v = 0; v < mask.size(); ++v)
    if (mask[v]) {
      own += static_cast<double>(image.voxels[v]) * image.voxels[v];
      both += static_cast<double>(image.voxels[v]) * truth.voxels[v];
    }
  if (!(own > 0)) return;
  for (float& value : image.voxels)
    value *= static_cast<float>(both / own);
}

} // namespace

EvaluationReport evaluateStacks(const Volume& volume, const StacksCase& c, const EvaluationOptions& options) {
  ThreadPool pool(options.settings.threads);
  pool.setStop(options.stop);
  if (options.onMethod) options.onMethod("simulation");
  SimulatedStacks input = simulateStacks(volume, c, pool);
  const Volume& truth = input.truth;
  const GridGeometry grid = truth.geometry;
  const Mask body{grid, bodyMask(truth, options.stop)};
  const std::vector<std::uint8_t> mask = scoredMask(truth, body.voxels);
  const bool moves = c.motion > 0 || c.turn > 0;
  const int threads = options.settings.threads;

  EvaluationReport report;
  report.protocol = "stacks";
  report.caseName = caseName(c);
  report.peak = intensityRange(truth);
  report.range = formatted("PSNR peak: the truth's maximum minus minimum, %g.", report.peak);
  const auto score = [&](const std::string& name, const TimedVolume& run,
                         const std::optional<Uncertainty>& uncertainty = {},
                         const GaussianField* field = nullptr) -> MethodScore& {
    Volume image = *run.volume, deviation = uncertainty ? uncertainty->deviation : Volume{};
    if (moves) {
      const Affine3 toImage = registered(image, truth, mask);
      RenderOptions render;
      render.threads = threads;
      render.stop = options.stop;
      image = field ? Volume{truth.geometry,
                             innergs::render(*field, moved(truth.geometry, toImage), render).voxels}
                    : moved(image, truth, toImage, pool);
      if (uncertainty) deviation = moved(deviation, truth, toImage, pool);
    }
    scaleTo(image, truth, mask);
    const Quality quality = pooledQuality(image, truth, mask, report.peak, std::nullopt, options.stop);
    report.voxels = quality.voxels;
    MethodScore& method = report.methods.emplace_back();
    method.name = name;
    method.psnr = method.pooledPsnr = quality.psnr;
    method.ssim = quality.ssim;
    method.seconds = run.seconds;
    method.cpuSeconds = run.cpuSeconds;
    method.peakMemory = run.peakMemory;
    if (uncertainty) method.intervals = intervalScore(image, truth, mask, *uncertainty, deviation, 0);
    if (options.keepVolumes) method.volume = std::make_shared<const Volume>(std::move(image));
    return method;
  };
  const auto fitted = [&](const std::string& name, const Settings& settings) {
    ReconstructionResult result;
    const TimedVolume run = runMethod(name, options, [&] {
      ReconstructionInput job;
      job.stacks = input.stacks;
      job.outputGrid = grid;
      job.n4 = correctByN4;
      job.uncertainty = options.uncertainty && name == "gaussians";
      ReconstructionJob fit(std::move(job), settings);
      if (options.progress) fit.onProgress(options.progress);
      result = fit.run(options.stop);
      if (result.cancelled) throw Error(ErrorCode::Cancelled, "The evaluation was cancelled.");
      return std::move(result.volume);
    });
    std::vector<std::vector<Affine3>> poses;
    for (std::size_t s = 0; s < input.stacks.size(); ++s) {
      auto& found = poses.emplace_back();
      for (std::size_t k = 0; k < input.poses[s].size(); ++k) {
        const Affine3 whole = result.alignment.empty() ? Affine3{} : result.alignment[s].toOthers;
        found.push_back(result.sliceMotion.moved ? result.sliceMotion.slices[s][k].pose * whole : whole);
      }
    }
    MethodScore& method = score(name, run, result.uncertainty, &result.model->field);
    method.poses = poseErrors(input.stacks, input.poses, poses, body);
    if (c.shading > 0)
      method.bias = biasErrors(result.bias, result.alignment, input.shading, Mask{grid, mask});
    for (const std::string& warning : result.warnings)
      report.notes.push_back(name + ": " + warning);
    if (name != "gaussians") return;
    report.densified = result.densified;
    if (options.keepVolumes) report.model = result.model;
  };
  if (options.gaussians) {
    fitted("gaussians", options.settings);
    Settings off = options.settings;
    off.align = false;
    off.sliceMotion = SliceMotionKind::Off;
    off.biasField = BiasFieldKind::Off;
    off.n4 = false;
    if (!(off == options.settings)) fitted("uncorrected", off);
  }
  const std::span<const Stack> first(input.stacks.data(), 1);
  const auto interpolated = [&](const char* name, std::span<const Stack> stacks, Interpolation kind) {
    score(name, runMethod(name, options,
                          [&] { return averageUpsampled(stacks, grid, kind, threads, options.stop); }));
  };
  interpolated("linear", first, Interpolation::Linear);
  interpolated("cubic", first, Interpolation::Cubic);
  if (c.stacks > 1) {
    interpolated("average", input.stacks, Interpolation::Cubic);
    report.notes.push_back(
        "linear and cubic see the axial stack alone; average is the mean of all stacks, each "
        "interpolated by cubic B-splines.");
  }
  score("backprojection", runMethod("backprojection", options, [&] {
          return backProjectionBaseline(input.stacks, grid, {.threads = threads, .stop = options.stop});
        }));
  report.samples =
      formatted("%s voxels of the truth's body mask, %g mm or more from the faces of what was scanned, "
                "after one gain%s was removed from every method's volume.",
                countText(report.voxels).c_str(), kFromFaces, moves ? " and one rigid transform" : "");
  if (moves)
    report.notes.push_back(
        "Where that transform puts the truth's voxels, the Gaussians are rendered, and the "
        "other volumes interpolated by cubic B-splines.");
  if (options.keepVolumes) {
    report.truth = std::make_shared<const Volume>(std::move(input.truth));
    report.input = std::make_shared<const std::vector<Stack>>(std::move(input.stacks));
  }
  return report;
}

} // namespace innergs
