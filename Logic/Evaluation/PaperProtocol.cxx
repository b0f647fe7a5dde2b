#include "Evaluation/PaperProtocol.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Image/FilledImage.h"
#include "Core/Render/Render.h"
#include "Evaluation/EvaluationRuns.h"
#include "Evaluation/SliceInterpolation.h"

#include <algorithm>
#include <limits>
#include <random>

namespace innergs {
namespace {

constexpr Plane planes[3] = {Plane::Axial, Plane::Coronal, Plane::Sagittal};

// Seeded sampling without replacement; std::shuffle differs between standard libraries.
std::vector<std::int64_t> chooseSlices(std::int64_t slices, double fraction, std::mt19937_64& engine) {
  std::vector<std::int64_t> order(static_cast<std::size_t>(slices));
  for (std::int64_t k = 0; k < slices; ++k)
    order[k] = k;
  const auto count = std::clamp<std::int64_t>(std::llround(fraction * double(slices)), 1, slices - 2);
  for (std::int64_t k = 0; k < count; ++k)
    std::swap(order[k],
              order[k + static_cast<std::int64_t>(engine() % static_cast<std::uint64_t>(slices - k))]);
  order.resize(static_cast<std::size_t>(count));
  std::sort(order.begin(), order.end());
  return order;
}

bool isConstant(const Volume& volume, int axis, std::int64_t slice) {
  const auto& n = volume.geometry.size;
  const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const float first = volume.voxels[static_cast<std::size_t>(slice * stride[axis])];
  for (std::int64_t y = 0; y < n[v]; ++y)
    for (std::int64_t x = 0; x < n[u]; ++x)
      if (volume.voxels[static_cast<std::size_t>(slice * stride[axis] + y * stride[v] + x * stride[u])] !=
          first)
        return false;
  return true;
}

// Scores per plane and averaged over the planes; image(axis) is the volume to score for the slices along an
// axis.
void score(MethodScore& method, const EvaluationInput& input, double peak,
           const std::function<const Volume&(int)>& image) {
  double psnrSum = 0, ssimSum = 0, pooledErrors = 0;
  std::int64_t pooledVoxels = 0, scoredPlanes = 0;
  for (Plane plane : planes) {
    const int axis = sliceAxis(input.truth.geometry, plane);
    PlaneScore result{plane, 0, 0, 0, 0};
    double errors = 0;
    std::int64_t voxels = 0, finite = 0;
    for (std::int64_t slice : input.scored[axis]) {
      const Quality q = sliceQuality(image(axis), input.truth, axis, slice, peak);
      if (q.voxels == 0) continue;
      ++result.slices;
      result.ssim += q.ssim;
      voxels += q.voxels;
      if (std::isinf(q.psnr)) continue; // identical, so without a finite mean
      ++finite;
      result.psnr += q.psnr;
      errors += double(q.voxels) * std::pow(10.0, -q.psnr / 10);
    }
    method.perPlane.push_back(result);
    if (result.slices == 0) continue;
    ++scoredPlanes;
    result.psnr = finite ? result.psnr / double(finite) : std::numeric_limits<double>::infinity();
    result.ssim /= double(result.slices);
    result.pooledPsnr = -10 * std::log10(errors / double(voxels));
    psnrSum += result.psnr;
    ssimSum += result.ssim;
    pooledErrors += errors;
    pooledVoxels += voxels;
    method.perPlane.back() = result;
  }
  method.psnr = psnrSum / double(scoredPlanes);
  method.ssim = ssimSum / double(scoredPlanes);
  method.pooledPsnr = -10 * std::log10(pooledErrors / double(pooledVoxels));
}

/// A voxel is observed unless all three planes hold it out.
Stack unionStack(const EvaluationInput& input) {
  const GridGeometry& g = input.truth.geometry;
  Stack stack;
  stack.image = input.truth;
  stack.profile = SliceProfile::Point;
  stack.thickness = g.spacing[2];
  stack.name = "slices of three planes";
  stack.observed.assign(stack.image.voxels.size(), 1);
  for (std::int64_t k : input.heldOut[2])
    for (std::int64_t j : input.heldOut[1])
      for (std::int64_t i : input.heldOut[0]) {
        const auto p = static_cast<std::size_t>(i + g.size[0] * (j + g.size[1] * k));
        stack.observed[p] = 0;
        stack.image.voxels[p] = 0;
      }
  return stack;
}

/// All slices of one plane except the held-out ones.
Stack planeStack(const EvaluationInput& input, Plane plane) {
  const int axis = sliceAxis(input.truth.geometry, plane);
  Stack stack;
  stack.image = withSliceAxis(input.truth, axis);
  stack.profile = SliceProfile::Point;
  stack.name = std::string(planeName(plane)) + " slices";
  stack.observed.assign(stack.image.voxels.size(), 1);
  const auto& size = stack.image.geometry.size;
  for (std::int64_t slice : input.heldOut[axis]) {
    std::fill_n(stack.observed.begin() + slice * size[0] * size[1], size[0] * size[1], std::uint8_t{0});
    std::fill_n(stack.image.voxels.begin() + slice * size[0] * size[1], size[0] * size[1], 0.f);
  }
  return stack;
}

/// The field as seen by slices along a grid axis, in the grid's own order.
Volume renderAlong(const GaussianField& field, const GridGeometry& grid, int axis,
                   const EvaluationOptions& options) {
  RenderOptions rendering;
  rendering.threads = options.settings.threads;
  rendering.instructionSet = options.settings.instructionSet;
  rendering.selection = options.settings.selection;
  rendering.stop = options.stop;
  Volume volume = render(field, withSliceAxis(grid, axis), rendering);
  for (int turn = axis; turn < 2; ++turn) // I, J, K → J, K, I → K, I, J → I, J, K; the swap is an involution
    volume = withSliceAxis(volume, axis);
  return volume;
}

/// The Gaussians' volume as seen along each grid axis; the same volume if it does not depend on the axis.
std::array<std::shared_ptr<const Volume>, 3> gaussianImages(const EvaluationInput& input, bool perPlane,
                                                            const EvaluationOptions& options,
                                                            EvaluationReport& report, double& seconds) {
  EvaluationOptions keeping = options;
  keeping.keepVolumes = options.keepVolumes || perPlane;
  const TimedVolume run = runMethod("gaussians", options, [&] {
    return reconstructGaussians(input.stacks, input.truth.geometry, keeping, report);
  });
  seconds = run.seconds;
  std::array<std::shared_ptr<const Volume>, 3> images{run.volume, run.volume, run.volume};
  for (int axis = 0; axis < 2 && perPlane; ++axis)
    images[axis] =
        std::make_shared<const Volume>(renderAlong(report.model->field, input.truth.geometry, axis, options));
  if (!options.keepVolumes) report.model.reset();
  return images;
}

} // namespace

EvaluationInput paperInput(const Volume& volume, double heldOutFraction, std::uint64_t seed, bool perPlane) {
  checkGeometry(volume.geometry, "The volume");
  if (!(heldOutFraction > 0 && heldOutFraction < 0.5))
    throw Error(ErrorCode::InvalidArgument, "The held-out fraction must lie between 0 and 0.5.");
  EvaluationInput input;
  input.truth = withSliceAxis(volume, sliceAxis(volume.geometry, Plane::Axial));
  const GridGeometry& g = input.truth.geometry;
  for (int axis = 0; axis < 3; ++axis)
    if (g.size[axis] < 8)
      throw Error(ErrorCode::InvalidArgument,
                  "The paper's protocol needs at least 8 slices in each of the three planes.");
  std::mt19937_64 engine(seed);
  for (Plane plane : planes) {
    const int axis = sliceAxis(g, plane);
    input.heldOut[axis] = chooseSlices(g.size[axis], heldOutFraction, engine);
  }
  // Empty slices test nothing, as their PSNR is arbitrary up to infinity; they stay held out from the fit.
  input.scored = input.heldOut;
  for (int axis = 0; axis < 3; ++axis)
    std::erase_if(input.scored[axis],
                  [&](std::int64_t slice) { return isConstant(input.truth, axis, slice); });

  if (perPlane)
    for (Plane plane : planes)
      input.stacks.push_back(planeStack(input, plane));
  else
    input.stacks.push_back(unionStack(input));
  return input;
}

Settings withoutResidualGrid(Settings settings) {
  settings.consistency = false;
  return settings;
}

EvaluationReport evaluatePaper(const Volume& volume, const EvaluationOptions& given) {
  EvaluationOptions options = given;
  options.settings = withoutResidualGrid(options.settings);
  const bool perPlane = options.gaussians && chosenBlending(options.settings) == Blending::Alpha;
  EvaluationInput input = paperInput(volume, options.heldOutFraction, options.settings.seed, perPlane);
  EvaluationReport report;
  report.protocol = "paper";
  report.caseName = formatted("withheld-%g%%", 100 * options.heldOutFraction);
  report.peak = intensityRange(input.truth);
  report.range = formatted(
      "PSNR peak: the truth's maximum minus minimum, %g; per slice, then the mean over slices and planes.",
      report.peak);
  std::int64_t counts[3];
  for (Plane plane : planes) {
    const int axis = sliceAxis(input.truth.geometry, plane);
    counts[static_cast<int>(plane)] = static_cast<std::int64_t>(input.scored[axis].size());
    report.voxels +=
        counts[static_cast<int>(plane)] * input.truth.geometry.voxelCount() / input.truth.geometry.size[axis];
  }
  report.samples =
      formatted("the %s axial, %s coronal and %s sagittal held-out slices that are not empty, "
                "background included; nearly all of "
                "their voxels were seen in the other two planes.",
                countText(counts[0]).c_str(), countText(counts[1]).c_str(), countText(counts[2]).c_str());

  if (options.gaussians) {
    MethodScore method;
    method.name = "gaussians";
    const auto images = gaussianImages(input, perPlane, options, report, method.seconds);
    if (options.keepVolumes) method.volume = images[2];
    score(method, input, report.peak, [&](int axis) -> const Volume& { return *images[axis]; });
    report.methods.push_back(std::move(method));
  }
  const std::pair<const char*, Interpolation> baselines[] = {{"linear", Interpolation::Linear},
                                                             {"cubic", Interpolation::Cubic},
                                                             {"lanczos", Interpolation::Lanczos}};
  for (const auto& [name, kind] : baselines) {
    MethodScore method;
    method.name = name;
    std::array<TimedVolume, 3> images;
    for (int axis = 0; axis < 3; ++axis) {
      EvaluationOptions quiet = options;
      if (axis > 0) quiet.onMethod = nullptr;
      images[axis] = runMethod(name, quiet, [&, k = kind] {
        return interpolateSlices(input.truth, axis, input.heldOut[axis], k);
      });
      method.seconds += images[axis].seconds;
    }
    score(method, input, report.peak, [&](int axis) -> const Volume& { return *images[axis].volume; });
    report.methods.push_back(std::move(method));
  }
  report.notes.push_back(
      "linear, cubic and lanczos see only the other slices of the same plane, the Gaussians all "
      "three planes.");
  if (options.gaussians)
    report.notes.push_back(
        "Gaussians without a residual grid, which would hold the voxels seen in the other planes.");
  if (perPlane)
    report.notes.push_back(
        "The image of alpha blending depends on the slicing direction: every held-out slice "
        "is scored as rendered in its own plane, which was fitted to the other slices of it. A saved volume "
        "or picture shows the rendering along the axial slices' normal alone.");

  MethodScore leak;
  const Volume copy = filledImage(unionStack(input)).image;
  score(leak, input, report.peak, [&](int) -> const Volume& { return copy; });
  report.notes.push_back(formatted(
      "This protocol leaks: copying the voxels seen in the other planes and taking the nearest seen voxel "
      "for "
      "the rest scores %.2f dB pooled over the held-out slices (SSIM %.4f). Judge by the held-out protocol.",
      leak.pooledPsnr, leak.ssim));
  if (options.keepVolumes) {
    report.truth = std::make_shared<const Volume>(std::move(input.truth));
    report.input = std::make_shared<const std::vector<Stack>>(std::move(input.stacks));
  }
  return report;
}

} // namespace innergs
