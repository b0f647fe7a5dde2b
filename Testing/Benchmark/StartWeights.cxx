#include "Core/Image/NoiseEstimate.h"
#include "Core/Prediction/NetworkTraining.h"
#include "IO/VolumeIO.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <deque>
#include <fstream>

using namespace innergs;

/// Writes the weights that the prediction's networks start from (Core/Prediction/StartWeights.h): learned
/// from the in-plane images of the given scans, degraded as if thin slices lay four pixels apart.
namespace {

constexpr int kPhases = 4;
constexpr double kRate = 4e-3;

struct Scan {
  TrainingPlanes planes;
  SliceSampling sampling;
  PatchFilter filter;
  PairShape shape;
  float floor = 1;
  double noise = 0;
};

Scan prepared(const std::string& file, const MatrixKernels& kernels, ThreadPool& pool) {
  Stack stack;
  stack.image = readVolume(file);
  GridGeometry& g = stack.image.geometry;
  stack.thickness = std::min(g.spacing[0], g.spacing[1]);
  g.spacing[2] = kPhases * std::min(g.spacing[0], g.spacing[1]); // only in-plane images are used
  GridGeometry thin = g;
  thin.spacing[2] /= kPhases;
  thin.size[2] = (g.size[2] - 1) * kPhases + 1;
  Scan scan;
  scan.sampling = sliceSampling(stack, thin, kPhases);
  const FilledImage filled = filledImage(stack);
  const std::vector<std::uint8_t> body = knownBody(filled, {});
  const double noise = estimateNoise(filled.image, body);
  double squares = 0; // of the profile's weights: averaging takes noise away, which pairs get back
  for (const float w : scan.sampling.slice.weights)
    squares += static_cast<double>(w) * w;
  scan.noise = noise * std::sqrt(std::max(0.0, 1 - squares));
  scan.planes = trainingPlanes(filled, body, scan.sampling, {}, pool);
  scan.shape = pairShape(scan.planes, scan.sampling, g.size[2], TrainingPlan{}.most);
  scan.filter = learnFilter(scan.planes, scan.sampling, scan.shape, scan.noise, 1, kernels, pool);
  scan.floor = static_cast<float>(std::max(0.05 * scan.filter.typical, noise));
  return scan;
}

void write(const std::string& file, const ConvolutionNetwork& network) {
  std::ofstream out(file);
  const std::size_t count = network.matrices().back().at;
  for (std::size_t i = 0; i < count; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(network.parameters()[i]);
    out << (bits + 0x7fff + (bits >> 16 & 1)) / 65536 << (i % 24 == 23 || i + 1 == count ? ",\n" : ",");
  }
  if (!out.flush()) throw std::runtime_error("Cannot write " + file + ".");
}

} // namespace

int main(int count, char** arguments) {
  CLI::App app("Learns the weights that the prediction's networks start from.");
  std::vector<std::string> files;
  std::string folder = ".";
  int steps = 40000;
  app.add_option("scans", files, "Scans with fine in-plane detail")->required();
  app.add_option("--output", folder, "Folder for StartWeights16.inc and StartWeights32.inc");
  app.add_option("--steps", steps, "Training steps");
  CLI11_PARSE(app, count, arguments);
  try {
    ThreadPool pool(0);
    const MatrixKernels& kernels = matrixKernels({});
    std::deque<Scan> scans;
    std::vector<TrainingSource> sources;
    for (const std::string& file : files) {
      const Scan& scan = scans.emplace_back(prepared(file, kernels, pool));
      sources.push_back({scan.planes, scan.sampling, scan.filter, scan.shape, scan.floor, scan.noise});
    }
    for (const int channels : {16, 32}) {
      TrainingPlan plan;
      plan.channels = channels;
      plan.steps = steps;
      plan.rate = kRate;
      plan.fromScratch = true;
      write(folder + "/StartWeights" + std::to_string(channels) + ".inc",
            trainNetwork(sources, plan, 1, kernels, pool, [&](double done) {
              std::fprintf(stderr, "\r%d channels: %3.0f %%", channels, 100 * done);
            }));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "\n%s\n", error.what());
    return 1;
  }
}
