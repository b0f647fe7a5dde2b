#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Fit/Plan.h"
#include "Evaluation/PaperProtocol.h"
#include "IO/AtomicFile.h"
#include "IO/VolumeIO.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <thread>

namespace innergs::bench {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Options {
  std::string volume, json;
  Settings settings;
  std::int64_t gaussians = 74088;
  int iterations = 0;
  bool responsiveness = false;
};

/// Converts the fit's own PSNR to the truth's range.
struct Monitor {
  double scale = 1;         // the fit's range without outliers, image units
  int coarseIterations = 0; // their PSNR is for data at half resolution: not comparable
};

Monitor monitorOf(const Volume& volume, Settings settings) {
  const EvaluationInput input = paperInput(volume, 0.05, settings.seed);
  const IntensityMap map = chooseIntensityMap(input.stacks);
  return {map.scale, makePlan(settings, measureTraits(input.stacks, map)).coarseIterations};
}

/// Protocol P, with the fit's PSNR over time and its memory. A separate process, so that the peak is the
/// fit's.
Json paper(const Volume& volume, const Options& o, std::int64_t atStart) {
  const Monitor monitor = monitorOf(volume, o.settings);
  std::vector<std::pair<double, double>> fitted; // seconds, dB
  std::int64_t peak = 0;
  std::clock_t cpu = 0;
  double cpuSeconds = 0;
  int iterations = 0;
  std::int64_t gaussians = 0;
  EvaluationOptions options;
  options.settings = o.settings;
  options.progress = [&](const Progress& p) {
    if (p.phase != Phase::Fitting || p.iteration == 0) return;
    if (p.iteration > monitor.coarseIterations) fitted.emplace_back(p.elapsed, p.trainingPsnr);
    iterations = p.iteration;
    gaussians = p.gaussians;
  };
  options.onMethod = [&](const std::string& name) {
    if (name == "gaussians")
      cpu = std::clock();
    else if (peak == 0) {
      peak = peakMemory();
      cpuSeconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    }
  };
  const EvaluationReport report = evaluatePaper(volume, options);

  const double shift = 20 * std::log10(report.peak / monitor.scale);
  Json result;
  result["size"] = volume.geometry.size;
  result["gaussians"] = gaussians;
  result["iterations"] = iterations;
  result["samples"] = report.samples;
  result["notes"] = report.notes;
  for (const MethodScore& m : report.methods)
    result["methods"][m.name] = {
        {"psnr", m.psnr}, {"pooled_psnr", m.pooledPsnr}, {"ssim", m.ssim}, {"seconds", m.seconds}};
  result["cpu_seconds"] = cpuSeconds;
  result["fitted"] = Json::array();
  for (const auto& [seconds, psnr] : fitted)
    result["fitted"].push_back({seconds, psnr + shift});
  result["memory"] = {{"at_start", atStart}, {"peak", peak}, {"volume", 4 * volume.geometry.voxelCount()}};
  return result;
}

/// Seconds to the first preview, and from a stop request to the end of run().
Json responsiveness(const Volume& volume, const Settings& settings) {
  double preview = 0, cancel = 0;
  for (int delay : {0, 40, 90}) { // ms: at different points of an iteration
    Stack stack;
    stack.image = volume;
    stack.profile = SliceProfile::Point;
    ReconstructionInput input;
    input.stacks = {std::move(stack)};
    ReconstructionJob job(std::move(input), settings);
    std::atomic<bool> shown = false;
    job.onPreview([&](const Volume&) { shown = true; });
    std::stop_source stop;
    const auto begun = Clock::now();
    Clock::time_point stopped;
    std::jthread user([&] {
      while (!shown && since(begun) < 20)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      preview = std::max(preview, since(begun));
      std::this_thread::sleep_for(std::chrono::milliseconds(delay));
      stopped = Clock::now();
      stop.request_stop();
    });
    const bool cancelled = job.run(stop.get_token()).cancelled;
    const auto ended = Clock::now();
    user.join();
    if (!cancelled)
      throw Error(ErrorCode::Internal, "The fit ended before it could be stopped: give more iterations.");
    cancel = std::max(cancel, std::chrono::duration<double>(ended - stopped).count());
  }
  return {{"first_preview", preview}, {"cancel", cancel}};
}

int run(Options& o, std::int64_t atStart) {
  const Volume volume = readVolume(o.volume);
  o.settings.gaussians = o.gaussians;
  Json result;
  if (o.responsiveness) {
    result = responsiveness(volume, o.settings);
  } else {
    if (o.iterations > 0) o.settings.iterations = o.iterations;
    result = paper(volume, o, atStart);
  }
  writeFileAtomically(o.json, result.dump(1) + "\n");
  return 0;
}

} // namespace
} // namespace innergs::bench

int main(int argc, char** argv) try {
  const std::int64_t atStart = innergs::peakMemory();
  innergs::bench::Options options;
  CLI::App app("Protocol P with time to quality and memory, or the response to a user, as JSON");
  app.add_option("volume", options.volume, "The truth")->required();
  app.add_option("--json", options.json, "File to write")->required();
  app.add_option("--gaussians", options.gaussians, "Budget");
  app.add_option("--iterations", options.iterations, "Iterations, in place of the preset's");
  app.add_option("--threads", options.settings.threads, "0 = all cores");
  app.add_flag("--responsiveness", options.responsiveness,
               "Times of the first preview and of a cancellation instead");
  CLI11_PARSE(app, argc, argv);
  return innergs::bench::run(options, atStart);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
