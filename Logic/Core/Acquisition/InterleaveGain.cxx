#include "Core/Acquisition/InterleaveGain.h"

#include "Core/Base/Median.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/Otsu.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

constexpr double kLeastGain = 0.01, kStandardErrors = 4, kAgreeing = 0.8;
constexpr std::size_t kFewestSlices = 6;
constexpr double kLeastPixels = 0.2;        // of those of the slice with most: the caps of a body differ more
constexpr std::int64_t kEnough = 1'000'000; // voxels: some are left out of more
constexpr double kToDeviation = 1.4826, kErrorOfMedian = 1.2533; // for normal distributions

/// The median logarithm of a slice's ratio to the mean of its neighbours, or to the only observed one, where
/// all of them are above the threshold.
struct SliceRatio {
  double logarithm = 0;
  std::size_t pixels = 0;
};

SliceRatio sliceRatio(const Stack& scan, std::int64_t slice, double threshold, std::int64_t step) {
  const std::int64_t plane = scan.image.geometry.size[0] * scan.image.geometry.size[1];
  const float* voxels = scan.image.voxels.data();
  const auto known = [&](std::int64_t at) { return isKnown(scan, static_cast<std::size_t>(at)); };
  std::vector<double> ratios;
  for (std::int64_t v = slice * plane; v < (slice + 1) * plane; v += step) {
    if (!known(v) || !(voxels[v] > threshold)) continue;
    double sum = 0;
    int count = 0, body = 0;
    for (const std::int64_t beside : {v - plane, v + plane}) {
      if (!known(beside)) continue;
      sum += voxels[beside];
      ++count;
      body += voxels[beside] > threshold;
    }
    if (count > 0 && body == count) ratios.push_back(voxels[v] * count / sum);
  }
  const std::size_t pixels = ratios.size();
  return {pixels > 0 ? std::log(median(std::move(ratios))) : 0, pixels};
}

} // namespace

double interleaveGain(const Stack& scan, ThreadPool& pool) {
  const std::int64_t slices = scan.image.geometry.size[2];
  if (!scan.poses.empty() || slices < static_cast<std::int64_t>(kFewestSlices) + 2) return 1;
  const std::int64_t step = 1 + scan.image.geometry.voxelCount() / kEnough;
  std::vector<float> known;
  for (std::int64_t v = 0; v < scan.image.geometry.voxelCount(); v += step)
    if (isKnown(scan, static_cast<std::size_t>(v))) known.push_back(scan.image.voxels[v]);
  if (known.empty() || *std::min_element(known.begin(), known.end()) < 0) return 1;
  const double threshold = std::max(0.0, foregroundThreshold(known));
  std::vector<SliceRatio> ratios(static_cast<std::size_t>(slices));
  pool.run(slices - 2, [&](std::int64_t n) { ratios[n + 1] = sliceRatio(scan, n + 1, threshold, step); });
  std::size_t most = 0;
  for (const SliceRatio& ratio : ratios)
    most = std::max(most, ratio.pixels);
  std::vector<double> steps; // from even to odd slices
  for (std::int64_t k = 1; k + 1 < slices; ++k)
    if (ratios[k].pixels > 0 &&
        static_cast<double>(ratios[k].pixels) >= kLeastPixels * static_cast<double>(most))
      steps.push_back(k % 2 != 0 ? ratios[k].logarithm : -ratios[k].logarithm);
  if (steps.size() < kFewestSlices) return 1;
  const double gain = median(steps);
  std::vector<double> deviations;
  for (const double s : steps)
    deviations.push_back(std::abs(s - gain));
  const double error = kErrorOfMedian * kToDeviation * median(std::move(deviations)) /
                       std::sqrt(static_cast<double>(steps.size()));
  const auto alike = std::count_if(steps.begin(), steps.end(), [gain](double s) { return s * gain > 0; });
  if (std::abs(gain) < std::max(std::log1p(kLeastGain), kStandardErrors * error) ||
      static_cast<double>(alike) < kAgreeing * static_cast<double>(steps.size()))
    return 1;
  return std::exp(gain);
}

void evenOutInterleaves(double gain, Stack& scan) {
  if (gain == 1) return;
  const std::int64_t plane = scan.image.geometry.size[0] * scan.image.geometry.size[1];
  const auto even = static_cast<float>(std::sqrt(gain)), odd = 1 / even;
  for (std::size_t v = 0; v < scan.image.voxels.size(); ++v)
    scan.image.voxels[v] *= static_cast<std::int64_t>(v) / plane % 2 == 0 ? even : odd;
}

std::string interleaveGainSentence(double gain, const std::string& name) {
  if (gain == 1) return {};
  return "Every second slice of " + name + " is " + formatted("%.1f", 100 * (std::max(gain, 1 / gain) - 1)) +
         " % brighter than those beside it, as where slices are acquired in two passes: they were made "
         "equally "
         "bright.";
}

} // namespace innergs
