#include "Document.h"
#include "Platform.h"
#include "SweepVolumes.h"
#include "Tables.h"

#include "Core/Base/Error.h"
#include "Core/Render/Render.h"
#include "IO/AtomicFile.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <thread>

namespace innergs::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string innergs, microbenchmarks, paper, source, work, data, colin27, brainweb, brainwebScript,
      document;
  std::vector<std::string> only;
  bool reuse = false, trial = false;

  bool wants(const std::string& section) const {
    return only.empty() || std::find(only.begin(), only.end(), section) != only.end();
  }
};

struct TestVolume {
  std::string name, path;
  std::string missing; // the reason if there is none
};

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Bench {
public:
  explicit Bench(Options options) : o_(std::move(options)) { fs::create_directories(o_.work); }

  bool failed() const { return failed_; }

  void run() {
    document(""); // reports problems with it before the work
    volumes_ = findVolumes();
    brainweb_ = &volumes_.back();
    std::string numbers = machine();
    if (o_.wants("speed")) numbers += "\n### Speed\n\n" + speedTable(speed());
    if (o_.wants("paper"))
      numbers +=
          "\n### Protocol P: BrainWeb T1 145×174×145, preset balanced, all cores\n\n" + paperTable(paper());
    if (o_.wants("held-out"))
      numbers += "\n### Protocol H: preset balanced, PSNR in dB pooled over the body / SSIM\n\n" +
                 heldOutTable(heldOut());
    if (o_.wants("stacks"))
      numbers += "\n### Protocol stacks: 5 mm slices, preset balanced\n\n" + stackTable(stacks());
    if (o_.wants("sweep"))
      numbers += "\n### Protocol H on the middle of every volume, along each axis, as it is and blurred "
                 "along it by 1 and 2 "
                 "slices: preset fast\n\n" +
                 sweepTable(sweep());
    std::cout << "\n" << numbers << std::flush;
    writeFileAtomically(o_.document, document(numbers));
    std::cout << "\nWritten to " << o_.document << "\n";
  }

private:
  std::string document(const std::string& numbers) const {
    return withNumbers(fs::exists(o_.document) ? contents(o_.document) : emptyDocument(), numbers);
  }

  std::string workFile(const std::string& name) const { return (fs::path(o_.work) / name).string(); }

  /// Runs a program that writes `json`; a failure or a missing volume becomes a line in the table.
  Outcome measure(const std::string& title, const std::string& json, std::vector<std::string> words) {
    const fs::path result = workFile(json), log = workFile(fs::path(json).stem().string() + ".log");
    std::error_code ignored;
    const bool current =
        o_.reuse && fs::exists(result) && fs::last_write_time(result) > fs::last_write_time(words[0]);
    std::cout << title << " ... " << std::flush;
    if (!current) {
      fs::remove(result, ignored);
      fs::remove(log, ignored);
      const auto begun = std::chrono::steady_clock::now();
      const RunStatus status = runProgram(words, log.string());
      if (status.interrupted)
        throw Error(ErrorCode::Cancelled, "Interrupted; --reuse goes on with what was measured.");
      if (status.code != 0 || !fs::exists(result)) {
        std::cout << "failed, see " << log.string() << "\n";
        failed_ = true;
        return {{}, "failed with exit code " + std::to_string(status.code)};
      }
      std::cout << std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begun)
                       .count()
                << " s\n";
    } else {
      std::cout << "reused\n";
    }
    return {nlohmann::json::parse(contents(result)), {}};
  }

  Outcome skipped(const std::string& title, const TestVolume& volume) {
    std::cout << title << " skipped: " << volume.missing << "\n";
    return {{}, "skipped: " + volume.missing};
  }

  std::vector<TestVolume> findVolumes() {
    const auto volume = [](const std::string& name, const fs::path& path, const std::string& missing) {
      return TestVolume{name, path.string(), fs::exists(path) ? "" : missing};
    };
    const std::string absent = " is not in the folder INNERGS_TEST_DATA";
    const fs::path data = o_.data;
    std::vector<TestVolume> volumes{
        volume("studyforrest T1", data / "A_studyforrest_T1w_1mm_crop.nii.gz",
               "A_studyforrest_T1w_1mm_crop.nii.gz" + absent),
        volume("ICBM152", data / "A_icbm152_2009a_sym_t1_1mm.nii.gz",
               "A_icbm152_2009a_sym_t1_1mm.nii.gz" + absent),
        volume("Colin27", o_.colin27, "INNERGS_COLIN27 is not there (Debian package mricron-data)"),
        volume("BrainWeb", o_.brainweb, "neither INNERGS_BRAINWEB nor INNERGS_BRAINWEB_SCRIPT is there")};
    TestVolume& brainweb = volumes.back();
    if (!brainweb.missing.empty() && fs::exists(o_.brainwebScript)) {
      const fs::path folder = workFile("brainweb"), file = folder / "brainweb_t1_145x174x145.nii.gz";
      if (!fs::exists(file)) {
        std::cout << "Fetching BrainWeb ... " << std::flush;
        const RunStatus status =
            runProgram({"sh", o_.brainwebScript, folder.string()}, workFile("brainweb.log"));
        std::cout << (status.code == 0 ? "done\n" : "failed, see " + workFile("brainweb.log") + "\n");
      }
      brainweb = volume("BrainWeb", file, "INNERGS_BRAINWEB_SCRIPT could not fetch it");
    }
    return volumes;
  }

  Outcome speed() {
    std::vector<std::string> words{o_.microbenchmarks, "--benchmark_out_format=json",
                                   "--benchmark_out=" + workFile("speed.json")};
    if (brainweb_->missing.empty()) words.push_back(brainweb_->path);
    if (o_.trial)
      words.push_back("--benchmark_filter=AVX2|scalar|iteration|oblique|plane_query|moving_plane");
    return measure("Micro-benchmarks", "speed.json", std::move(words));
  }

  PaperOutcomes paper() {
    const TestVolume& brainweb = *brainweb_;
    const auto one = [&](const std::string& title, const std::string& json,
                         std::vector<std::string> options) {
      if (!brainweb.missing.empty()) return skipped(title, brainweb);
      std::vector<std::string> words{o_.paper, brainweb.path, "--json", workFile(json)};
      words.insert(words.end(), options.begin(), options.end());
      if (o_.trial && json != "paper-response.json") words.insert(words.end(), {"--iterations", "5"});
      return measure(title, json, std::move(words));
    };
    return {one("Protocol P, 74,088 Gaussians", "paper-74088.json", {"--gaussians", "74088"}),
            one("Protocol P, 300,000 Gaussians", "paper-300000.json", {"--gaussians", "300000"}),
            one("Preview and cancel", "paper-response.json", {"--responsiveness"})};
  }

  Outcome evaluate(const std::string& title, const std::string& json, const std::string& volume,
                   const std::string& preset, const std::vector<std::string>& options) {
    std::vector<std::string> words{o_.innergs, "evaluate", volume,   "--quiet",
                                   "--preset", preset,     "--json", workFile(json)};
    words.insert(words.end(), options.begin(), options.end());
    if (o_.trial) words.insert(words.end(), {"--iterations", "2"});
    return measure(title, json, std::move(words));
  }

  struct Case {
    std::string name;
    std::vector<std::string> options;
  };

  std::vector<HeldOutOutcome> heldOut() {
    std::vector<Case> cases;
    for (const char* k : {"2", "3", "4", "5", "6"})
      cases.push_back({std::string("keep-every-") + k, {"--keep-every", k}});
    cases.push_back({"thick-4", {"--thickness", "4"}});
    cases.push_back({"orthogonal-2-thick-4", {"--orthogonal", "2", "--thickness", "4"}});
    std::vector<HeldOutOutcome> outcomes;
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      const TestVolume& volume = volumes_[v];
      if (!volume.missing.empty()) {
        outcomes.push_back({volume.name, "", skipped("Protocol H, " + volume.name, volume)});
        continue;
      }
      for (const Case& c : cases) {
        const std::string json = "held-out-" + std::to_string(v) + "-" + c.name + ".json";
        outcomes.push_back({volume.name, c.name,
                            evaluate("Protocol H, " + volume.name + ", " + c.name, json, volume.path,
                                     "balanced", c.options)});
      }
    }
    return outcomes;
  }

  /// Thick scans at right angles of two heads. With the first seed also the uncertainty, which takes a second
  /// fit; with the others the time and memory of one.
  std::vector<StackOutcome> stacks() {
    const std::vector<Case> cases{{kStill, {}},
                                  {kTwoStill, {"--orthogonal", "2"}},
                                  {kMoved, {"--motion", "3", "--turn", "3"}},
                                  {kMovedMuch, {"--motion", "5", "--turn", "5"}},
                                  {kShaded, {"--shading", "0.4", "--bias-field", "auto"}}};
    const std::pair<const TestVolume&, const char*> volumesAndNoise[] = {{volumes_[1], "2.55"},
                                                                         {volumes_[0], "2.24"}};
    std::vector<StackOutcome> outcomes;
    for (const int seed : {1, 2})
      for (const auto& [volume, noise] : volumesAndNoise) {
        const std::string title = "Stacks, " + volume.name;
        if (!volume.missing.empty()) {
          if (seed == 1) outcomes.push_back({volume.name, "", seed, skipped(title, volume)});
          continue;
        }
        for (std::size_t c = 0; c < cases.size(); ++c) {
          const auto& [name, own] = cases[c];
          std::vector<std::string> options{"--protocol", "stacks", "--central", o_.trial ? "40" : "120",
                                           "--noise",    noise,    "--seed",    std::to_string(seed)};
          options.insert(options.end(), own.begin(), own.end());
          if (seed == 1 && name != kTwoStill && name != kMovedMuch) options.push_back("--uncertainty");
          const std::string json = "stacks-" + std::to_string(&volume - volumes_.data()) + "-" +
                                   std::to_string(c) + "-" + std::to_string(seed) + ".json";
          outcomes.push_back({volume.name, name, seed,
                              evaluate(title + ", " + name + ", seed " + std::to_string(seed), json,
                                       volume.path, "balanced", options)});
        }
      }
    return outcomes;
  }

  /// The middle of each volume, along each of its axes, sharp and smooth.
  std::vector<HeldOutOutcome> sweep() {
    const fs::path data = o_.data;
    std::vector<TestVolume> volumes = volumes_;
    for (const auto& [name, file] : {std::pair{"abdominal MR", "B_abdomen_spgr_FA15.nii.gz"},
                                     {"wrist", "B_wrist01_LAVA_static.nii.gz"},
                                     {"CT", "C_ct_abdomen_pelvis_3mm.nii.gz"},
                                     {"fetal MR", "F_fetal_run-1_T2w.nii.gz"}})
      volumes.push_back(
          {name, (data / file).string(),
           fs::exists(data / file) ? "" : std::string(file) + " is not in the folder INNERGS_TEST_DATA"});
    std::vector<HeldOutOutcome> outcomes;
    for (std::size_t v = 0; v < volumes.size(); ++v) {
      const std::string title = "Sweep, " + volumes[v].name;
      if (!volumes[v].missing.empty()) {
        outcomes.push_back({volumes[v].name, "", skipped(title, volumes[v])});
        continue;
      }
      const std::string folder = "sweep-" + std::to_string(v);
      for (const SweepVolume& part : makeSweepVolumes(volumes[v].path, workFile(folder)))
        for (const auto& [option, k] : {std::pair{"--keep-every", "2"},
                                        {"--keep-every", "3"},
                                        {"--keep-every", "4"},
                                        {"--keep-every", "5"},
                                        {"--keep-every", "6"},
                                        {"--thickness", "2"},
                                        {"--thickness", "4"},
                                        {"--thickness", "6"}}) {
          const std::string name = part.name + (option + 1) + "-" + k, json = folder + "-" + name + ".json";
          outcomes.push_back({volumes[v].name, name,
                              evaluate(title + ", " + name, json, part.path.string(), "fast", {option, k})});
        }
    }
    return outcomes;
  }

  std::string git(std::vector<std::string> words) {
    const std::string log = workFile("git.log");
    fs::remove(log);
    words.insert(words.begin(), {"git", "-C", o_.source});
    if (runProgram(words, log).code != 0) return {};
    std::string text = contents(log);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r'))
      text.pop_back();
    return text;
  }

  std::string machine() {
    char date[32] = "";
    const std::time_t now = std::time(nullptr);
    std::strftime(date, sizeof(date), "%Y-%m-%d", std::gmtime(&now));
    const std::string model = processorModel(), commit = git({"rev-parse", "--short", "HEAD"});
    const bool changed =
        !git({"status", "--porcelain", "--", "Logic", "Testing/Benchmark", "CMakeLists.txt"}).empty();
    std::string text;
    if (o_.trial)
      text += "**A trial of the benchmarks with a few iterations: the figures mean nothing.**\n\n";
    text += std::string(date) + ", " + (model.empty() ? "unknown processor" : model) + ", " +
            std::to_string(std::thread::hardware_concurrency()) + " cores, " + instructionSets().front() +
            "; commit " + (commit.empty() ? "unknown" : commit) + (changed ? " with local changes" : "") +
            "; " + INNERGS_COMPILER + ".\n";
    return text;
  }

  Options o_;
  std::vector<TestVolume> volumes_;
  const TestVolume* brainweb_ = nullptr;
  bool failed_ = false;
};

} // namespace
} // namespace innergs::bench

int main(int argc, char** argv) try {
  innergs::bench::Options options;
  CLI::App app("Runs the benchmarks, prints their tables and writes them into a document (make bench)");
  app.add_option("--innergs", options.innergs, "The innergs command")->required();
  app.add_option("--microbenchmarks", options.microbenchmarks, "The micro-benchmarks' program")->required();
  app.add_option("--paper", options.paper, "Protocol P's program")->required();
  app.add_option("--source", options.source, "The repository, to name the commit")->required();
  app.add_option("--work", options.work, "Folder for results and logs of every step")->required();
  app.add_option("--data", options.data, "Folder with real test volumes");
  app.add_option("--colin27", options.colin27, "The Colin27 head");
  app.add_option("--brainweb", options.brainweb, "BrainWeb T1, 145x174x145");
  app.add_option("--brainweb-script", options.brainwebScript, "Fetches it into the folder it is given");
  app.add_option("--document", options.document, "Markdown file to write the numbers into")->required();
  app.add_option("--only", options.only, "speed, paper, held-out, stacks, sweep")->delimiter(',');
  app.add_flag("--reuse", options.reuse, "Keep results in the work folder that are newer than the programs");
  app.add_flag("--trial", options.trial, "A few iterations, to see that everything runs; not a measurement");
  CLI11_PARSE(app, argc, argv);
  innergs::bench::Bench bench(options);
  bench.run();
  return bench.failed() ? 1 : 0;
} catch (const std::exception& error) {
  std::cerr << "\n" << error.what() << "\n";
  return 1;
}
