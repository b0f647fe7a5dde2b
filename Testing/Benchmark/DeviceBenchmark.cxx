// Speed and memory of a CUDA device, compared with the targets and the processors of the same machine, as
// Markdown.
// Needs neither ITK nor a profiler; with --host, the host executor does the same at a tiny size.
#include "DeviceRuns.h"
#include "KernelWork.h"
#include "Markdown.h"
#include "Nifti.h"
#include "Platform.h"
#include "TimedExecutor.h"

#include "Core/Base/Error.h"
#ifdef INNERGS_BENCHMARK_CUDA
#include "Cuda/CudaExecutor.h"
#endif

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

namespace innergs::bench {
namespace {

class Report {
public:
  explicit Report(const Options& o) : options_(o) {}

  void run() {
    Sizes sizes;
    if (options_.host) sizes = {343, 12, 24, 6, 48};
    Volume volume = options_.volume.empty() ? (options_.host ? waves(24, 28, 24) : waves(145, 174, 145))
                                            : readPlainNifti(options_.volume);
    const auto& n = volume.geometry.size;
    const JobRun cold = job(volume, sizes, "cuda:0", 0); // before anything else starts the device
    if (cold.device != "cuda:0")
      throw Error(ErrorCode::Internal, "The job did not run on the device: is the plugin there?");
    where(n, sizes);
    jobs(volume, sizes, cold);
    const Scene scene = sceneOf(volume, sizes, Blending::Normalised);
    iterations(scene, "");
    kernels(scene);
    plane(scene, volume, sizes);
    large(sizes);
    iterations(sceneOf(volume, sizes, Blending::Alpha), "alpha blending, slices of 3 axes: ");
    const std::string text = head_ + "\n\n" + table_.text() + "\n" + profile_;
    std::printf("\n%s\n", text.c_str());
    if (!options_.output.empty()) std::ofstream(options_.output) << text;
  }

private:
  void add(const std::string& what, const std::string& value, const std::string& target = "",
           const std::string& met = "") {
    table_.add({what, value, target, met});
    std::printf("%s: %s\n", what.c_str(), value.c_str()); // kept if a time limit ends the run
    std::fflush(stdout);
  }
  static std::string yes(bool met) { return met ? "yes" : "no"; }

  void where(const std::array<std::int64_t, 3>& n, const Sizes& sizes) {
    char text[512];
    std::string name = options_.host ? "host executor (a trial run of this program: no figures)" : "";
#ifdef INNERGS_BENCHMARK_CUDA
    if (!options_.host) {
      facts_ = cuda::cudaFacts(0);
      std::ifstream version("/proc/driver/nvidia/version");
      std::string driver;
      std::getline(version, driver);
      std::snprintf(text, sizeof text,
                    "%s, %.1f GiB, %d multiprocessors at up to %.0f MHz, CUDA %d.%d (driver's %d.%d)",
                    cuda::cudaDevices().devices.front().name.c_str(),
                    static_cast<double>(facts_.memory) / (1 << 30), facts_.processors, 1e-6 * facts_.hertz,
                    facts_.runtime / 1000, facts_.runtime % 1000 / 10, facts_.driver / 1000,
                    facts_.driver % 1000 / 10);
      name = text;
      const auto at = driver.find("  "); // NVRM version: NVIDIA UNIX ... Module  580.159.04  ...
      if (at != std::string::npos)
        name += ", driver " + driver.substr(at + 2, driver.find(' ', at + 2) - at - 2);
    }
#endif
    std::snprintf(text, sizeof text, "; %s, %u threads. %s of %lld×%lld×%lld voxels, %lld Gaussians.",
                  processorModel().c_str(), std::thread::hardware_concurrency(),
                  options_.volume.empty()
                      ? "A synthetic volume"
                      : options_.volume.substr(options_.volume.find_last_of("/\\") + 1).c_str(),
                  static_cast<long long>(n[0]), static_cast<long long>(n[1]), static_cast<long long>(n[2]),
                  static_cast<long long>(sizes.gaussians));
    head_ = name + text;
    std::printf("%s\n", head_.c_str());
  }

  void jobs(const Volume& volume, const Sizes& sizes, const JobRun& cold) {
    std::vector<JobRun> warm;
    for (int i = 0; i < 3; ++i)
      warm.push_back(job(volume, sizes, "cuda:0", 0));
    std::sort(warm.begin(), warm.end(),
              [](const JobRun& a, const JobRun& b) { return a.seconds < b.seconds; });
    const JobRun& run = warm[1];
    std::vector<double> toPaper;
    for (const JobRun& w : warm)
      toPaper.push_back(w.toPaper);
    const double paper = std::isnan(toPaper[0] + toPaper[1] + toPaper[2]) ? NAN : median(toPaper);
    const JobRun all = job(volume, sizes, "cpu", 0), two = job(volume, sizes, "cpu", 2);
    add("time to 32.47 dB, preset balanced (all voxels fitted, pooled), median of 3", fixed(paper, 2) + " s",
        "≤ 0.3 s", yes(paper <= 0.3));
    add("of it before the first iteration (reading traits, start field)",
        fixed(run.firstIteration, 2) + " s");
    add("whole reconstruction, preset balanced, " + std::to_string(run.iterations) +
            " iterations, median of 3",
        fixed(run.seconds, 2) + " s (fit " + fixed(run.fitSeconds, 2) + " s)", "≤ 3 s",
        yes(run.seconds <= 3));
    add("the same, first of the process (starts the driver, loads the kernels, self-check)",
        fixed(cold.seconds, 2) + " s; 32.47 dB in " + fixed(cold.toPaper, 2) + " s");
    add("the same on the CPU: 2 threads; all", fixed(two.seconds, 2) + " s; " + fixed(all.seconds, 2) +
                                                   " s; 32.47 dB in " + fixed(two.toPaper, 2) + " s; " +
                                                   fixed(all.toPaper, 2) + " s");
    add("PSNR of the fitted samples: device; CPU", fixed(run.psnr, 2) + " dB; " + fixed(all.psnr, 2) + " dB",
        "within 0.05 dB", yes(run.psnr >= all.psnr - 0.05));
  }

  void iterations(const Scene& scene, const std::string& label) {
    const FitRequest request = requestOf(scene);
    double device = 0, relocating = 0;
    {
      cuda::Fit fit(executorOf(options_), request);
      device = iterationSeconds(fit, scene.field, options_.repeats);
      if (label.empty()) relocating = iterationSeconds(fit, scene.field, options_.repeats, 5);
    }
    const double two = cpuIterationSeconds(scene, 2, options_.repeats),
                 all = cpuIterationSeconds(scene, 0, options_.repeats);
    add(label + "one iteration", fixed(1e3 * device, 3) + " ms");
    if (label.empty()) add("one iteration, relocation every 5", fixed(1e3 * relocating, 3) + " ms");
    add(label + "one iteration on the CPU: 2 threads; all",
        fixed(1e3 * two, 1) + " ms; " + fixed(1e3 * all, 1) + " ms");
    add(label + "times as fast as 2 threads; all", fixed(two / device, 0) + "; " + fixed(all / device, 0),
        label.empty() ? "≥ 50; –" : "", label.empty() ? yes(two / device >= 50) : "");
    Profile profile;
    cuda::Fit fit(std::make_unique<TimedExecutor>(executorOf(options_), profile), request);
    fit.upload(scene.field, Adam(scene.field.size()), {});
    IterationOptions options;
    fit.iterate(options);
    fit.iterate(options); // the room for pairs is now known
    profile.clear();
    constexpr int kTrialIterations = 5;
    for (int i = 0; i < kTrialIterations; ++i)
      fit.iterate(options);
    double sum = 0;
    for (const auto& [name, t] : profile)
      sum += t.seconds;
    std::vector<std::pair<std::string, KernelTime>> sorted(profile.begin(), profile.end());
    std::sort(sorted.begin(), sorted.end(),
              [](const auto& a, const auto& b) { return a.second.seconds > b.second.seconds; });
    MarkdownTable table({label + "kernels of one iteration", "launches", "µs, each waited for", "share"});
    for (const auto& [name, t] : sorted)
      table.add({name, std::to_string(t.launches / kTrialIterations),
                 fixed(1e6 * t.seconds / kTrialIterations, 1), fixed(100 * t.seconds / sum, 1) + " %"});
    profile_ += table.text() + "\n";
  }

  void kernels(const Scene& scene) {
    const auto executor = executorOf(options_);
    HeavyKernels heavy(*executor, scene.field, scene.observations.front());
    const int launches = options_.host ? 1 : 50;
    const auto each = [&](const std::string& name, const KernelWork& work,
                          const std::function<void()>& launch) {
      launch();
      std::vector<double> seconds;
      for (int r = 0; r < options_.repeats; ++r)
        seconds.push_back(secondsOf(*executor,
                                    [&] {
                                      for (int i = 0; i < launches; ++i)
                                        launch();
                                    }) /
                          launches);
      const double s = median(seconds);
      char text[256];
      std::snprintf(text, sizeof text, "%.1f µs, %.2f·10⁹ evaluations/s", 1e6 * s,
                    1e-9 * work.evaluations / s);
      add(name, text);
      if (facts_.hertz <= 0 || facts_.bytesPerSecond <= 0) return;
      const double flops = 2.0 * facts_.lanes * facts_.processors * facts_.hertz,
                   issues = facts_.lanes / 32.0 * facts_.processors * facts_.hertz;
      std::snprintf(
          text, sizeof text,
          "%.1f %% of the multiply-adds, %.1f %% of the instruction slots, %.1f %% of the bandwidth",
          100 * work.flops / flops / s, 100 * work.instructions / issues / s,
          100 * work.bytes / facts_.bytesPerSecond / s);
      add(name + ": achieved (counted work / highest clock)", text);
    };
    each("Accumulate (forward)", heavy.accumulateWork, [&] { heavy.accumulate(); });
    each("Gather (gradient)", heavy.gatherWork, [&] { heavy.gather(); });
  }

  void plane(const Scene& scene, const Volume& volume, const Sizes& sizes) {
    const double ms = planeMilliseconds(options_, sizes, scene, volume);
    add("an oblique plane of " + std::to_string(sizes.plane) + "×" + std::to_string(sizes.plane) +
            ", copied to the host",
        fixed(ms, 3) + " ms", "≤ 1 ms", yes(ms <= 1));
  }

  void large(const Sizes& sizes) {
    std::int64_t gaussians = 0;
    double gib = NAN, process = NAN;
#ifdef INNERGS_BENCHMARK_CUDA
    if (!options_.host) cuda::cudaFacts(0); // resets the peak
#endif
    const double seconds = largeIteration(options_, sizes, gaussians);
#ifdef INNERGS_BENCHMARK_CUDA
    if (!options_.host) {
      const cuda::CudaFacts after = cuda::cudaFacts(0);
      gib = static_cast<double>(after.highest) / (1 << 30);
      process = static_cast<double>(after.memory - after.free - after.reserved + after.highest) / (1 << 30);
    }
#endif
    const std::string what =
        std::to_string(sizes.large) + "³ voxels, " + std::to_string(gaussians) + " Gaussians: ";
    add(what + "one iteration", fixed(1e3 * seconds, 1) + " ms");
    add(what + "most device memory; with the driver's own",
        fixed(gib, 2) + " GiB; " + fixed(process, 2) + " GiB", "< 16 GB", yes(process * 1.073741824 < 16));
  }

  Options options_;
#ifdef INNERGS_BENCHMARK_CUDA
  cuda::CudaFacts facts_;
#else
  struct {
    int processors = 0, lanes = 0;
    double hertz = 0, bytesPerSecond = 0;
  } facts_;
#endif
  std::string head_, profile_;
  MarkdownTable table_{{"quantity", "measured", "target", "met"}};
};

} // namespace
} // namespace innergs::bench

int main(int argc, char** argv) {
  using namespace innergs;
  bench::Options options;
  if (const char* volume = std::getenv("INNERGS_BRAINWEB")) options.volume = volume;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--host")
      options.host = true;
    else if (word == "--volume" && i + 1 < argc)
      options.volume = argv[++i];
    else if (word == "--output" && i + 1 < argc)
      options.output = argv[++i];
    else if (word == "--repeats" && i + 1 < argc)
      options.repeats = std::max(1, std::atoi(argv[++i]));
    else {
      std::printf("%s [--volume FILE.nii] [--output FILE.md] [--repeats N] [--host]\n", argv[0]);
      return word == "--help" ? 0 : 2;
    }
  }
  try {
    if (!options.host) {
#ifdef INNERGS_BENCHMARK_CUDA
      const DeviceList list = cuda::cudaDevices();
      const std::string problem = list.devices.empty() ? list.problem : "";
#else
      const std::string problem = "Built without nvcc.";
#endif
      if (!problem.empty()) {
        std::printf("NOTHING MEASURED: %s\n", problem.c_str());
        return 0;
      }
    }
    bench::Report(options).run();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
