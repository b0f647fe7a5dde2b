#include "Evaluation/ExperimentSelection.h"

#include "Core/Base/Error.h"
#include "Core/Base/Random.h"
#include "Core/Render/Candidates.h"
#include "Core/Render/GridRenderer.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <numbers>

namespace innergs {
namespace {

constexpr Selection kSelections[] = {Selection::Method1, Selection::Method2, Selection::Exact};

void check(const SelectionSimulation& s) {
  const auto require = [](bool ok, const char* sentence) {
    if (!ok) throw Error(ErrorCode::InvalidArgument, sentence);
  };
  require(s.gaussians > 0, "The simulation needs at least 1 Gaussian.");
  require(s.size > 0 && s.size <= 1024, "The simulation needs a cube of 1 to 1024 voxels.");
  require(s.clouds > 0, "The simulation needs at least 1 cloud.");
  require(s.threshold > 0 && s.threshold < 1, "The contribution threshold must lie between 0 and 1.");
  require(std::isfinite(s.low) && std::isfinite(s.high), "The means' limits must be finite.");
  require(s.low <= s.high, "The means' lower limit must not be above the upper one.");
  for (const double sigma : s.sigma)
    require(std::isfinite(sigma) && sigma > 0, "The simulation's Gaussians need positive sigmas.");
}

double radius(const SelectionSimulation& s) {
  return std::sqrt(-2 * std::log(s.threshold));
}

// A uniformly distributed rotation (Shoemake 1992).
void randomQuaternion(Random& random, float* q) {
  const double u = random.uniform(), a = 2 * std::numbers::pi * random.uniform(),
               b = 2 * std::numbers::pi * random.uniform();
  const double r = std::sqrt(1 - u), s = std::sqrt(u);
  q[0] = static_cast<float>(r * std::sin(a));
  q[1] = static_cast<float>(r * std::cos(a));
  q[2] = static_cast<float>(s * std::sin(b));
  q[3] = static_cast<float>(s * std::cos(b));
}

struct Shape {
  double mean[3], covariance[6], precision[6], largest; // largest eigenvalue
};

Shape shapeOf(const Gaussian& g) {
  Shape shape;
  const double q[4] = {g.quaternion[0], g.quaternion[1], g.quaternion[2], g.quaternion[3]};
  double r[9], scaled[9];
  math::rotation(q, r);
  shape.largest = 0;
  for (int k = 0; k < 3; ++k) {
    const double s = std::exp(static_cast<double>(g.logScale[k]));
    shape.largest = std::max(shape.largest, s * s);
    shape.mean[k] = g.mean[k];
    for (int i = 0; i < 3; ++i)
      scaled[3 * i + k] = r[3 * i + k] * s;
  }
  math::outer(scaled, shape.covariance);
  math::invertSymmetric(shape.covariance, shape.precision);
  return shape;
}

double squaredDistance(const Shape& s, double x, double y, double z) {
  const double a = x - s.mean[0], b = y - s.mean[1], c = z - s.mean[2];
  const double* p = s.precision;
  return p[0] * a * a + p[3] * b * b + p[5] * c * c + 2 * (p[1] * a * b + p[2] * a * c + p[4] * b * c);
}

// Area of the box that the selection evaluates for the Gaussian in a slice at t; negative: not reached.
double boxArea(const Shape& s, Selection selection, double t, double radius2) {
  const double dz = t - s.mean[2];
  if (selection == Selection::Method1) return std::abs(dz) <= 3 * std::sqrt(s.largest) ? 36 * s.largest : -1;
  const auto c = math::sliceConditional(s.covariance);
  const double u = c.covariance[0], uv = c.covariance[1], v = c.covariance[2];
  if (selection == Selection::Method2) {
    if (std::abs(dz) > 3 * std::sqrt(c.variance)) return -1;
    const double widest = 0.5 * (u + v) + std::sqrt(0.25 * (u - v) * (u - v) + uv * uv);
    return 36 * widest * std::exp(-0.5 * dz * dz / c.variance);
  }
  const double rest = radius2 - dz * dz / c.variance;
  return rest < 0 ? -1 : 4 * rest * std::sqrt(u * v); // the box around the ellipse
}

SampleGrid cube(int size) {
  SampleGrid grid;
  grid.nx = grid.ny = size;
  for (int k = 0; k < size; ++k)
    grid.z.push_back(k);
  return grid;
}

GridView viewOf(const SampleGrid& grid) {
  return {grid.nx, grid.ny, grid.planes(), grid.stride(), grid.z.data()};
}

std::vector<double> timings(std::span<const GaussianField> clouds, const SelectionSimulation& s,
                            const std::string& instructionSet, ThreadPool& pool) {
  using Clock = std::chrono::steady_clock;
  const SampleGrid grid = cube(s.size);
  std::vector<float> weights(grid.bufferSize()), numerators(grid.bufferSize());
  std::vector<GridRenderer> renderers;
  for (const Selection selection : kSelections)
    renderers.emplace_back(grid, kernelSet(instructionSet, selection), pool);
  std::vector<std::vector<double>> seconds(std::size(kSelections));
  for (int repetition = -1; repetition < s.repetitions; ++repetition) // the first is a warm-up
    for (std::size_t n = 0; n < renderers.size(); ++n) {
      pool.throwIfStopped();
      const auto start = Clock::now();
      for (const GaussianField& cloud : clouds)
        renderers[n].forward(cloud, {}, weights.data(), numerators.data());
      if (repetition >= 0)
        seconds[n].push_back(std::chrono::duration<double>(Clock::now() - start).count() /
                             static_cast<double>(clouds.size()));
    }
  std::vector<double> medians;
  for (auto& all : seconds) {
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
    medians.push_back(all.empty() ? 0 : all[all.size() / 2]);
  }
  return medians;
}

} // namespace

SelectionCounts& SelectionCounts::operator+=(const SelectionCounts& other) {
  contributing += other.contributing;
  candidates += other.candidates;
  falsePositives += other.falsePositives;
  falseNegatives += other.falseNegatives;
  slices += other.slices;
  area += other.area;
  return *this;
}

GaussianField simulatedCloud(const SelectionSimulation& s, std::uint64_t seed) {
  check(s);
  Random random(seed);
  GaussianField field;
  field.cutoff = radius(s) * (1 + 1e-5); // single-precision rounding must not lose a pixel at the threshold
  for (int n = 0; n < s.gaussians; ++n) {
    Gaussian g{};
    for (int a = 0; a < 3; ++a) {
      g.mean[a] = static_cast<float>(s.low + (s.high - s.low) * random.uniform());
      g.logScale[a] = static_cast<float>(std::log(s.sigma[a]));
    }
    randomQuaternion(random, g.quaternion);
    g.intensity = 1;
    field.gaussians.push_back(g);
  }
  return field;
}

SelectionCounts countCandidates(const GaussianField& cloud, const SelectionSimulation& s,
                                Selection selection) {
  check(s);
  ThreadPool pool(1);
  const SampleGrid grid = cube(s.size);
  const GridView view = viewOf(grid);
  std::vector<Projected> projected;
  project(cloud, {}, grid, {}, pool, projected, selection);
  const double radius2 = -2 * std::log(s.threshold);
  const TileRange everything{0, grid.ny, 0, grid.planes()};
  const std::size_t n = static_cast<std::size_t>(s.size);
  std::vector<std::uint8_t> candidate(n * n * n);
  SelectionCounts counts;
  for (std::size_t i = 0; i < projected.size(); ++i) {
    std::fill(candidate.begin(), candidate.end(), std::uint8_t{0});
    forEachCandidateRow(projected[i], view, selection, everything, [&](int k, int y, int x0, int x1) {
      std::fill_n(candidate.begin() + static_cast<std::ptrdiff_t>((k * n + y) * n + x0), x1 - x0,
                  std::uint8_t{1});
    });
    const Shape shape = shapeOf(cloud.gaussians[i]);
    std::size_t at = 0;
    for (int k = 0; k < s.size; ++k) {
      for (int y = 0; y < s.size; ++y)
        for (int x = 0; x < s.size; ++x, ++at) {
          const bool contributes = squaredDistance(shape, x, y, k) <= radius2;
          counts.contributing += contributes;
          counts.candidates += candidate[at];
          counts.falsePositives += candidate[at] && !contributes;
          counts.falseNegatives += contributes && !candidate[at];
        }
      if (const double area = boxArea(shape, selection, k, radius2); area >= 0) {
        ++counts.slices;
        counts.area += area;
      }
    }
  }
  return counts;
}

std::vector<SelectionScore> simulateSelections(const SelectionSimulation& s,
                                               const std::string& instructionSet, std::stop_token stop) {
  check(s);
  ThreadPool pool(1);
  pool.setStop(std::move(stop));
  std::vector<SelectionScore> scores;
  for (const Selection selection : kSelections)
    scores.emplace_back().selection = selection;
  std::vector<GaussianField> clouds;
  for (int c = 0; c < s.clouds; ++c) {
    pool.throwIfStopped();
    clouds.push_back(simulatedCloud(s, s.seed + static_cast<std::uint64_t>(c)));
    for (SelectionScore& score : scores)
      score.counts += countCandidates(clouds.back(), s, score.selection);
  }
  const std::vector<double> seconds = timings(clouds, s, instructionSet, pool),
                            scalar = timings(clouds, s, "scalar", pool);
  for (std::size_t n = 0; n < scores.size(); ++n) {
    scores[n].seconds = seconds[n];
    scores[n].scalarSeconds = scalar[n];
  }
  return scores;
}

namespace {

/// A sentence that compares Exact with Method 2.
std::string speedNote(std::span<const SelectionScore> scores) {
  double exact[2] = {}, method2[2] = {};
  for (const SelectionScore& score : scores) {
    double* seconds = score.selection == Selection::Exact     ? exact
                      : score.selection == Selection::Method2 ? method2
                                                              : nullptr;
    if (seconds) seconds[0] = score.seconds, seconds[1] = score.scalarSeconds;
  }
  const auto compared = [&](int n) {
    return exact[n] < method2[n] ? decimals(method2[n] / exact[n], 2) + " times faster"
                                 : decimals(exact[n] / method2[n], 2) + " times SLOWER";
  };
  return "Exact is " + compared(0) + " than Method 2 with the SIMD kernels and " + compared(1) +
         " with the scalar ones.";
}

} // namespace

ExperimentTable selectionTable(const SelectionSimulation& s, std::span<const SelectionScore> scores) {
  ExperimentTable table;
  table.name = "selection";
  table.title = "Candidate selection, simulation: " + std::to_string(s.gaussians) + " Gaussians in " +
                std::to_string(s.size) + "x" + std::to_string(s.size) + "x" + std::to_string(s.size) +
                " voxels, " + std::to_string(s.clouds) + " clouds";
  table.columns = {"selection",
                   "box_area",
                   "paper_area",
                   "false_positives",
                   "paper_false_positives",
                   "false_negatives",
                   "paper_false_negatives",
                   "candidates",
                   "paper_candidates",
                   "per_contributing",
                   "microseconds",
                   "scalar_microseconds",
                   "measured_on"};
  const double pixels = std::pow(s.size, 3) * s.clouds;
  double contributing = 0;
  for (const SelectionScore& score : scores) {
    const SelectionCounts& c = score.counts;
    contributing = static_cast<double>(c.contributing) / pixels;
    const auto perPixel = [&](std::int64_t count) { return static_cast<double>(count) / pixels; };
    const bool first = score.selection == Selection::Method1, exact = score.selection == Selection::Exact;
    const auto paper = [&](const char* method1, const char* method2) {
      return std::string(exact ? "" : first ? method1 : method2);
    };
    table.add({selectionName(score.selection), decimals(c.area / static_cast<double>(c.slices), 2),
               paper("209.80", "63.09"), decimals(perPixel(c.falsePositives), 3), paper("15.79", "1.82"),
               decimals(perPixel(c.falseNegatives), 4), paper("0", "0.126"),
               decimals(perPixel(c.candidates), 3), paper("16.70", "2.62"),
               decimals(static_cast<double>(c.candidates) / static_cast<double>(c.contributing), 3),
               decimals(1e6 * score.seconds, 1), decimals(1e6 * score.scalarSeconds, 1), "simulation"});
  }
  table.notes = {
      "Nothing is held out: a simulation without image data.",
      "A Gaussian contributes to a pixel of a slice where p >= " + decimals(s.threshold, 2) +
          " (peak 1): on average " + decimals(contributing, 3) +
          " do. False positives, false negatives and candidates are per pixel; per contributing is the "
          "candidates over the contributing ones; box area is in pixels, a mean over the slices that a "
          "Gaussian reaches (exact: the box around the ellipse, of which only the ellipse is visited).",
      "The paper does not give its covariances. Ours have sigma " + decimals(s.sigma[0], 3) + ", " +
          decimals(s.sigma[1], 3) + " and " + decimals(s.sigma[2], 3) +
          " voxels in uniformly random directions: the first reproduces Method 1's mean area exactly, the "
          "other two were chosen to come close to the paper's remaining figures.",
      "Time: rendering one cloud with the same kernels on one thread, median of " +
          std::to_string(s.repetitions) +
          " interleaved repetitions; the paper gives none per selection. The SIMD kernels evaluate full "
          "vectors and mask what is not a candidate, so their time is not proportional to the candidates; "
          "the scalar kernels evaluate exactly the candidates."};
  table.notes.push_back(speedNote(scores));
  return table;
}

} // namespace innergs
