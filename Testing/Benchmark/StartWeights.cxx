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
/// from the images of the given scans, degraded as if slices lay two to six pixels apart.
namespace {

constexpr int kPhases = 8;
constexpr double kRatios[] = {2, 3, 4, 6}; // slice distances, in pixels
constexpr std::int64_t kMostSamples = 2'000'000;

struct Scan {
  TrainingPlanes planes;
  SliceSampling sampling;
  PatchFilter filter;
  PairShape shape;
  float floor = 1;
  double noise = 0;
};

Scan prepared(const Volume& image, double ratio, bool thick, const NetworkKernels& kernels,
              ThreadPool& pool) {
  Stack stack;
  stack.image = image;
  GridGeometry& g = stack.image.geometry;
  g.spacing[2] = ratio * std::min(g.spacing[0], g.spacing[1]); // only in-plane images are used
  stack.thickness = g.spacing[2];
  stack.profile = thick ? SliceProfile::Box : SliceProfile::Point;
  GridGeometry thin = g;
  thin.spacing[2] /= kPhases;
  thin.size[2] = (g.size[2] - 1) * kPhases + 1;
  if (thick) thin.origin = g.indexToWorld()({0, 0, 0.5 / kPhases - 0.5});
  Scan scan;
  scan.sampling = sliceSampling(stack, thin, kPhases);
  const FilledImage filled = filledImage(stack);
  const std::vector<std::uint8_t> body = knownBody(filled, {});
  const double noise = estimateFineDetail(filled.image, body);
  // Averaging over `ratio` pixels takes noise away, which pairs get back.
  scan.noise = thick ? noise * std::sqrt(1 - 1 / ratio) : 0;
  TrainingPlanesRequest request;
  request.mostSamples = kMostSamples;
  scan.planes = trainingPlanes(filled, body, scan.sampling, request, pool);
  scan.shape = pairShape(scan.planes, scan.sampling, g.size[2], TrainingPlan{}.most);
  scan.filter = learnFilter(scan.planes, scan.sampling, scan.shape, scan.noise, 1, kernels, pool);
  scan.floor = static_cast<float>(std::max(0.05 * scan.filter.typical, noise));
  return scan;
}

/// The slices with pixels twice as wide: sharper from pixel to pixel.
Volume withWidePixels(const Volume& image) {
  const GridGeometry& g = image.geometry;
  Volume wide{g, {}};
  for (const int axis : {0, 1}) {
    wide.geometry.size[axis] /= 2;
    wide.geometry.spacing[axis] *= 2;
  }
  const auto& n = wide.geometry.size;
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const float* at = image.voxels.data() + 2 * i + g.size[0] * (2 * j + g.size[1] * k);
        wide.voxels.push_back(0.25f * (at[0] + at[1] + at[g.size[0]] + at[g.size[0] + 1]));
      }
  return wide;
}

/// The scan and, if its voxels are cubes, the same with the other axes as slice axes, each also with wide
/// pixels.
std::vector<Volume> viewsOf(const std::string& file) {
  std::vector<Volume> all{readVolume(file)};
  const Vec3 spacing = all.front().geometry.spacing;
  if (std::max({spacing[0], spacing[1], spacing[2]}) > 1.01 * std::min({spacing[0], spacing[1], spacing[2]}))
    return all;
  for (const int axis : {0, 1})
    all.push_back(withSliceAxis(all.front(), axis));
  for (const int view : {0, 1, 2})
    all.push_back(withWidePixels(all[view]));
  return all;
}

void write(const std::string& file, const ConvolutionNetwork& network) {
  std::ofstream out(file);
  const ConvolutionNetwork::Matrix last = network.matrices().back();
  std::size_t written = 0;
  const auto put = [&](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    out << (bits + 0x7fff + (bits >> 16 & 1)) / 65536 << (++written % 24 == 0 ? ",\n" : ",");
  };
  for (std::size_t i = 0; i < last.at; ++i)
    put(network.parameters()[i]);
  for (std::int64_t row = 0; row <= last.rows; ++row) // the biases follow the weights
    for (int phase = 0; phase < kPhases; ++phase)
      put(network.parameters()[last.at + row * last.columns + phase]);
  out << "\n";
  if (!out.flush()) throw std::runtime_error("Cannot write " + file + ".");
}

} // namespace

int main(int count, char** arguments) try {
  CLI::App app("Learns the weights that the prediction's networks start from.");
  std::vector<std::string> files;
  std::string folder = ".";
  int steps = 30000;
  double rate = 4e-3;
  bool further = false;
  std::vector<int> widths{16, 32};
  std::vector<std::string> profiles{"Thin", "Thick"};
  app.add_option("scans", files, "Scans with fine in-plane detail")->required();
  app.add_option("--output", folder, "Folder for StartWeightsThin16.inc and so on");
  app.add_option("--steps", steps, "Training steps");
  app.add_option("--rate", rate, "Largest rate of training");
  app.add_flag("--further", further, "Goes on from the weights that the program has");
  app.add_option("--channels", widths, "Channels of the networks");
  app.add_option("--profiles", profiles, "Thin, Thick or both");
  CLI11_PARSE(app, count, arguments);
  ThreadPool pool(0);
  const NetworkKernels& kernels = networkKernels({});
  for (const std::string& profile : profiles) {
    std::deque<Scan> scans;
    std::vector<TrainingSource> sources;
    for (const std::string& file : files)
      for (const Volume& image : viewsOf(file))
        for (const double ratio : kRatios) {
          const Scan& scan = scans.emplace_back(prepared(image, ratio, profile == "Thick", kernels, pool));
          sources.push_back({scan.planes, scan.sampling, scan.filter, scan.shape, scan.floor, scan.noise});
        }
    for (const int channels : widths) {
      TrainingPlan plan;
      plan.channels = channels;
      plan.steps = steps;
      plan.rate = rate;
      plan.fromScratch = !further;
      const std::string name = profile + std::to_string(channels);
      write(folder + "/StartWeights" + name + ".inc",
            trainNetwork(sources, plan, 1, kernels, pool, [&](double done) {
              std::fprintf(stderr, "\r%s: %3.0f %%", name.c_str(), 100 * done);
            }));
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "\n%s\n", error.what());
  return 1;
}
