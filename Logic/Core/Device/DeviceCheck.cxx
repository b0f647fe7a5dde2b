#include "Core/Device/DeviceCheck.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Fit/CpuFitDevice.h"
#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Projected.h"
#include "Core/Render/RenderPoints.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr double kTolerance = 1e-3; // devices are tested to 1e-4
constexpr int kSize[3] = {36, 21, 5};

/// Gaussians of many orientations and sizes in an image of waves, seen through thick slices.
struct Probe {
  GaussianField field;
  FitRequest request;

  explicit Probe(Blending blending) {
    Stack stack;
    stack.image.geometry.size = {kSize[0], kSize[1], kSize[2]};
    for (int k = 0; k < kSize[2]; ++k)
      for (int j = 0; j < kSize[1]; ++j)
        for (int i = 0; i < kSize[0]; ++i)
          stack.image.voxels.push_back(
              static_cast<float>(0.5 + 0.3 * std::sin(0.4 * i + 0.2 * k) * std::cos(0.5 * j)));
    const bool thick = blending == Blending::Normalised;
    stack.profile = thick ? SliceProfile::Box : SliceProfile::Point;
    field.blending = blending;
    field.linearIntensity = thick;
    field.cutoff = 2.2;
    request.observations = std::make_shared<const std::vector<Observation>>(observe(stack, {}, {}, false));
    const Observation& seen = request.observations->front();
    const ProjectionRules rules{static_cast<float>(field.cutoff * field.cutoff), blending, thick,
                                Selection::Exact, seen.psf};
    const ProjectionFrame frame = projectionFrame(seen.grid);
    for (int n = 0; n < 150; ++n) {
      const auto wave = [&](double rate) { return static_cast<float>(std::sin(rate * (n + 1))); };
      Gaussian g{};
      for (int a = 0; a < 3; ++a) {
        g.mean[a] = (0.5f + 0.55f * wave(1.3 + 0.9 * a)) * static_cast<float>(kSize[a] - 1);
        g.logScale[a] = 0.4f + 0.5f * wave(2.1 + 0.7 * a);
        g.slope[a] = thick ? 0.02f * wave(0.7 + 0.6 * a) : 0.f;
      }
      for (int a = 0; a < 4; ++a)
        g.quaternion[a] = 0.3f + wave(0.37 + 0.41 * a);
      g.logWeight = blending == Blending::Alpha ? wave(0.9) : 0.3f * wave(0.9);
      g.intensity = 0.5f + 0.4f * wave(1.7);
      Projected projected;
      projectGaussian(g, nullptr, frame, rules, projected);
      if (edgeClearance(projected, seen.grid) > 1e-4f) field.gaussians.push_back(g);
    }
    request.rules.loss = {LossKind::L2, 0.02, 0.2, 0.8};
    request.rules.bounds = {-2, 4};
    request.rules.densify.limit = 200;
    request.rules.densify.thresholds.gradient = 1e-3;
    request.blending = blending;
    request.linearIntensity = field.linearIntensity;
    request.gaussians = 200;
  }
};

/// Records the first disagreement.
class Judge {
public:
  const std::string& verdict() const { return verdict_; }

  void compare(const char* what, std::span<const float> found, std::span<const float> expected,
               double least = 1e-30) {
    if (!verdict_.empty()) return;
    double largest = 0, off = found.size() == expected.size() ? 0 : HUGE_VAL;
    for (std::size_t i = 0; i < expected.size() && off < HUGE_VAL; ++i) {
      const double difference = std::fabs(static_cast<double>(found[i]) - expected[i]);
      off = std::isfinite(difference) ? std::max(off, difference) : HUGE_VAL;
      largest = std::max(largest, std::fabs(static_cast<double>(expected[i])));
    }
    const double share = off / std::max({largest, least, 1e-30});
    if (share <= kTolerance) return;
    verdict_ = share < 100 ? formatted("its %s is %.2g %% off the CPU's", what, 100 * share)
                           : formatted("its %s is nothing like the CPU's", what);
  }
  /// Compares the 16 parameters of each Gaussian, each relative to its own largest value (one that is nearly
  /// 0 everywhere is just rounding).
  void compareColumns(const char* what, std::span<const float> found, std::span<const float> expected) {
    if (found.size() != expected.size()) return compare(what, found, expected);
    const double floor = 1e-4 * largestOf(expected);
    std::vector<float> a, b;
    for (std::size_t column = 0; column < 16; ++column) {
      a.clear(), b.clear();
      for (std::size_t at = column; at < expected.size(); at += 16)
        a.push_back(found[at]), b.push_back(expected[at]);
      compare(what, a, b, floor);
    }
  }
  static double largestOf(std::span<const float> values) {
    double largest = 0;
    for (float x : values)
      largest = std::max(largest, std::fabs(static_cast<double>(x)));
    return largest;
  }
  void compare(const char* what, double found, double expected) {
    const float a[] = {static_cast<float>(found)}, b[] = {static_cast<float>(expected)};
    compare(what, a, b);
  }

private:
  std::string verdict_;
};

std::span<const float> floats(const GaussianField& f) {
  return {reinterpret_cast<const float*>(f.gaussians.data()), 16 * f.gaussians.size()};
}

/// Compares the result of the first step only; many steps would hardly change the field. Adam's first step
/// follows the gradient's sign, which is rounding where it is near 0; the four quaternion components belong
/// together.
void judgeStep(const GaussianField& start, const FitState& found, const FitState& expected, Judge& judge) {
  const auto from = floats(start), to = floats(found.field), right = floats(expected.field);
  const std::vector<float>& gradient = expected.adam.moment1;
  if (to.size() != from.size() || right.size() != from.size() || gradient.size() != from.size()) return;
  double largest[16] = {};
  for (std::size_t at = 0; at < from.size(); ++at)
    largest[at % 16] = std::max(largest[at % 16], std::fabs(static_cast<double>(gradient[at])));
  const auto sure = [&](std::size_t at) {
    return std::fabs(gradient[at]) > 2 * kTolerance * std::max(largest[at % 16], 1e-30);
  };
  std::vector<float> a, b;
  for (std::size_t column = 0; column < 16; ++column) {
    a.clear(), b.clear();
    for (std::size_t row = 0; row < from.size(); row += 16) {
      bool counts = sure(row + column);
      if (column >= 6 && column < 10)
        for (std::size_t c = 6; c < 10; ++c)
          counts = counts && sure(row + c);
      if (!counts) continue;
      a.push_back(to[row + column] - from[row + column]);
      b.push_back(right[row + column] - from[row + column]);
    }
    judge.compare("step", a, b, 1e-5);
  }
}

/// Moments that decide clearly which Gaussians are relocated, so that rounding cannot, and that are too large
/// for Adam to move anything.
Adam clearMoments(const GaussianField& field) {
  const auto spread = [](std::size_t i, double rate) { // all different
    const double x = static_cast<double>(i) * rate;
    return static_cast<float>(1e8 * (1 + 7 * (x - std::floor(x))));
  };
  Adam adam(field.size());
  for (std::size_t i = 0; i < field.gaussians.size(); ++i) {
    float* m = adam.moment2.data() + 16 * i;
    std::fill_n(m, 16, 1e8f);
    const float* s = field.gaussians[i].logScale;
    m[0] = m[1] = m[2] = spread(i, 0.6180339887) * std::exp(-2 * (s[0] + s[1] + s[2]) / 3);
    m[11] = spread(i, 0.7548776662);
  }
  return adam;
}

/// Reorders `found` like `expected`, by the means: the order of neighbours along the sorting curve may depend
/// on a single bit.
void align(FitState& found, const FitState& expected) {
  const std::size_t n = expected.field.gaussians.size();
  if (found.field.gaussians.size() != n || found.adam.moment1.size() != 16 * n ||
      found.adam.moment2.size() != 16 * n)
    return; // the comparison reports it
  std::vector<std::uint8_t> taken(n);
  const FitState from = found;
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t nearest = n;
    float least = HUGE_VALF;
    for (std::size_t j = 0; j < n; ++j) {
      const float *a = from.field.gaussians[j].mean, *b = expected.field.gaussians[i].mean;
      const float distance = std::fabs(a[0] - b[0]) + std::fabs(a[1] - b[1]) + std::fabs(a[2] - b[2]);
      if (!taken[j] && !(distance >= least)) nearest = j, least = distance;
    }
    if (nearest == n) return; // only with NaNs
    taken[nearest] = 1;
    found.field.gaussians[i] = from.field.gaussians[nearest];
    std::copy_n(from.adam.moment1.begin() + 16 * nearest, 16, found.adam.moment1.begin() + 16 * i);
    std::copy_n(from.adam.moment2.begin() + 16 * nearest, 16, found.adam.moment2.begin() + 16 * i);
  }
}

void judgeFit(DevicePlugin& plugin, int device, const Probe& probe, Judge& judge) {
  ThreadPool pool(1);
  CpuFitDevice cpu(probe.request, kernelSet("scalar"), pool);
  const std::unique_ptr<FitDevice> fit = plugin.makeFit(device, probe.request);
  if (!fit) throw Error(ErrorCode::Internal, "it offers no fit");
  const Adam adam(probe.field.size());
  IterationOptions options;
  options.accumulateGradients = true;
  options.rates = {0.02, 0.01, 0.01, 0.02, 0.01, 0.001};
  FitState found, expected;
  const auto fetch = [&] {
    fit->download(&found.field, &found.adam, &found.accumulator);
    cpu.download(&expected.field, &expected.adam, &expected.accumulator);
    align(found, expected);
    judge.compareColumns("gradient", found.adam.moment1, expected.adam.moment1);
    judge.compareColumns("squared gradient", found.adam.moment2, expected.adam.moment2);
    judge.compareColumns("field", floats(found.field), floats(expected.field));
  };
  fit->upload(probe.field, adam, {});
  cpu.upload(probe.field, adam, {});
  const LossSum a = fit->iterate(options), b = cpu.iterate(options);
  judge.compare("loss", a.loss, b.loss);
  judge.compare("error", a.squared, b.squared);
  judge.compare("number of samples", static_cast<double>(a.samples), static_cast<double>(b.samples));
  fetch();
  judgeStep(probe.field, found, expected, judge);
  judge.compare("positional gradient", found.accumulator.sum, expected.accumulator.sum);
  // Starts from the same state, so that rounding does not decide who is chosen.
  fit->upload(expected.field, expected.adam, expected.accumulator);
  const DensifyCounts grown = fit->densify(), cpuGrown = cpu.densify();
  judge.compare("number of Gaussians", static_cast<double>(grown.split + grown.cloned - grown.pruned),
                static_cast<double>(cpuGrown.split + cpuGrown.cloned - cpuGrown.pruned));
  fetch();
  const Adam clear = clearMoments(probe.field);
  const std::int64_t last = static_cast<std::int64_t>(probe.request.observations->size()) - 1;
  std::vector<float> slopes(16 * probe.field.gaussians.size()), right(slopes.size());
  const LossSum one = fit->gradient(probe.field, last, slopes),
                cpuOne = cpu.gradient(probe.field, last, right);
  judge.compare("loss of one scan", one.loss, cpuOne.loss);
  judge.compareColumns("gradient of one scan", slopes, right);
  options.accumulateGradients = false;
  options.relocate = RelocationPlan{0.1, probe.request.rules.bounds.minLogScale};
  fit->upload(probe.field, clear, {});
  cpu.upload(probe.field, clear, {});
  fit->iterate(options);
  cpu.iterate(options);
  fetch();
}

void judgeRendering(DevicePlugin& plugin, int device, const GaussianField& field, Judge& judge) {
  const std::shared_ptr<FieldDevice> rendering = plugin.makeField(device, field);
  if (!rendering) throw Error(ErrorCode::Internal, "it offers no rendering");
  SampleGrid grid;
  grid.indexToModel = {{{{{0.8, 0.3, 0.1}, {-0.3, 0.7, 0.2}, {0.1, -0.3, 0.9}}}}, {4, 6, 0}};
  grid.nx = 30;
  grid.ny = 17;
  grid.z = {0.5, 2};
  ThreadPool pool(1);
  GridRenderer renderer(grid, kernelSet("scalar"), pool);
  std::vector<float> w(grid.bufferSize()), n(w.size()), expected;
  renderer.forward(field, {}, w.data(), n.data());
  for (int row = 0; row < grid.ny * grid.planes(); ++row)
    for (int x = 0; x < grid.nx; ++x) {
      const std::size_t at = static_cast<std::size_t>(row) * grid.stride() + x;
      expected.push_back(field.blending == Blending::Normalised
                             ? n[at] / (w[at] + static_cast<float>(field.epsilon))
                             : n[at]);
    }
  std::vector<float> found(expected.size());
  rendering->renderGrid(grid, {}, {}, found.data(), {});
  judge.compare("rendering", found, expected);
  std::vector<Vec3> points;
  for (int i = 0; i < 60; ++i)
    points.push_back({1.0 + 0.55 * i, 10 + 9 * std::sin(0.7 * i), 2 + 2 * std::cos(1.1 * i)});
  RenderOptions options;
  options.threads = 1;
  options.instructionSet = "scalar";
  options.scannerUnits = false;
  std::vector<float> values(points.size());
  rendering->renderPoints(points, {}, values.data(), {});
  judge.compare("rendering of points", values, renderPoints(field, points, options));
}

} // namespace

std::string deviceDisagreement(DevicePlugin& plugin, int device) {
  Judge judge;
  for (const Blending blending : {Blending::Normalised, Blending::Alpha, Blending::Additive}) {
    const Probe probe(blending);
    judgeFit(plugin, device, probe, judge);
    judgeRendering(plugin, device, probe.field, judge);
    if (!judge.verdict().empty()) return judge.verdict() + " (" + blendingName(blending) + " blending)";
  }
  return {};
}

} // namespace innergs
