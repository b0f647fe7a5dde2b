#include "Core/Prediction/ProfileEstimate.h"

#include "Core/Base/NumberText.h"
#include "Core/Image/NoiseEstimate.h"
#include "Core/Prediction/StructureFunction.h"
#include "Core/Prediction/TrainingPairs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace innergs {
namespace {

constexpr std::int64_t kFewestSlices = 5, kFewestPixels = 16;
constexpr double kFewestSamples = 2000; // minimum of differences per mean
constexpr double kMostNoise = 0.7;      // maximum share of noise in a mean

/// The x at which f, linear in x² between its samples, first falls to 0.
std::optional<double> rootInSquares(std::span<const double> x, std::span<const double> f) {
  if (f[0] <= 0) return x[0];
  for (std::size_t i = 1; i < x.size(); ++i)
    if (f[i] <= 0) {
      const double a = x[i - 1] * x[i - 1], b = x[i] * x[i];
      return std::sqrt(a + (b - a) * f[i - 1] / (f[i - 1] - f[i]));
    }
  return std::nullopt;
}

/// Removes two pixels along the body's outline in every slice.
void erode(std::vector<std::uint8_t>& body, const std::array<std::int64_t, 3>& n) {
  for (int round = 0; round < 2; ++round) {
    const std::vector<std::uint8_t> before = body;
    for (std::int64_t row = 0; row < n[1] * n[2]; ++row)
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const std::int64_t v = row * n[0] + i, j = row % n[1];
        body[v] = before[v] && (i == 0 || before[v - 1]) && (i + 1 == n[0] || before[v + 1]) &&
                  (j == 0 || before[v - n[0]]) && (j + 1 == n[1] || before[v + n[0]]);
      }
  }
}

std::string millimetres(double value) {
  return numberText(std::round(value * 10) / 10);
}

} // namespace

ProfileEstimate estimateProfile(const Stack& stack, ThreadPool& pool) {
  checkStack(stack);
  const GridGeometry& g = stack.image.geometry;
  ProfileEstimate estimate;
  estimate.spacing = g.spacing[2];
  const auto unknown = [&](const std::string& why) {
    estimate.sentence = "The slice thickness cannot be estimated from the image: " + why;
    return estimate;
  };
  if (g.size[2] < kFewestSlices) return unknown("they are too few.");
  if (std::min(g.size[0], g.size[1]) < kFewestPixels) return unknown("they have too few pixels.");
  const FilledImage filled = filledImage(stack);
  pool.throwIfStopped();
  std::vector<std::uint8_t> body = knownBody(filled, pool.stopToken());
  const double noise = estimateFineDetail(filled.image, body);
  erode(body, g.size);
  if (!(noise > 0)) return unknown("it is constant, or one of labels.");

  const double finer = std::min(g.spacing[0], g.spacing[1]);
  std::vector<StructureLines> lines;
  std::vector<double> pixel;
  for (const int axis : {0, 1}) {
    if (g.spacing[axis] > 1.1 * finer) continue;
    lines.emplace_back(filled.image, body, axis, noise);
    pixel.push_back(g.spacing[axis]);
  }
  // Finds the thickness: the in-plane blur of that width which makes the image equally smooth along and
  // across.
  constexpr double steps[] = {0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4};
  const SliceProfile profile =
      stack.profile == SliceProfile::Gaussian ? SliceProfile::Gaussian : SliceProfile::Box;
  std::vector<double> thickness, mean;
  std::vector<std::vector<double>> byAxis(lines.size());
  double noiseShare = 0;
  for (const double step : steps) {
    double sum = 0;
    bool enough = true;
    std::vector<double> here;
    for (std::size_t a = 0; a < lines.size(); ++a) {
      const StructureFunctions f =
          lines[a].after(profileFilter(profile, step * g.spacing[2] / pixel[a]), pool);
      enough = enough && f.samples >= kFewestSamples;
      if (step == 0) noiseShare = std::max(noiseShare, f.noiseShare);
      here.push_back(f.roughness());
      sum += here.back() / static_cast<double>(lines.size());
    }
    if (!enough) break;
    for (std::size_t a = 0; a < lines.size(); ++a)
      byAxis[a].push_back(here[a]);
    thickness.push_back(step * g.spacing[2]);
    mean.push_back(sum);
  }
  if (thickness.size() < 6) return unknown("it shows too little of the body.");
  if (noiseShare > kMostNoise) return unknown("it is too noisy.");
  const auto root = rootInSquares(thickness, mean);
  if (!root) return unknown("it is smoother across the slices than any slice profile would make it.");
  estimate.known = true;
  estimate.thickness = *root;
  double spread = 0;
  for (const auto& f : byAxis) {
    const auto own = rootInSquares(thickness, f);
    spread = std::max(spread, own ? std::abs(*own - *root) / std::max(*root, 0.25 * g.spacing[2]) : 1.0);
  }
  estimate.confidence = std::clamp(1 - spread, 0.0, 1.0) * (1 - noiseShare);
  estimate.sentence = "Slices look " + millimetres(estimate.thickness) + " mm thick, " +
                      millimetres(estimate.spacing) + " mm apart.";
  return estimate;
}

} // namespace innergs
