#include "CLI/Command.h"
#include "CLI/ExperimentPictures.h"
#include "CLI/Interrupt.h"
#include "CLI/Options.h"
#include "CLI/ProgressDisplay.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Evaluation/ExperimentDynamic.h"
#include "Evaluation/ExperimentSegmentation.h"
#include "Evaluation/ExperimentSelection.h"
#include "Evaluation/JitteredPhantom.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/OutputFiles.h"
#include "IO/SegmentNames.h"
#include "IO/TimeSeriesIO.h"
#include "Text/PhraseReport.h"
#include "Text/Terminology.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <map>

namespace innergs::cli {
namespace {

constexpr std::int64_t kQuickSize = 40;       // voxels along each edge
const char* const kPrediction = "prediction"; // an ablation of its own

struct ExperimentOptions {
  std::vector<std::string> names;
  bool all = false, quick = false, quiet = false;
  std::string volume, series, output, textModel;
  std::vector<std::string> labels, labelNames;
  std::int64_t gaussians = kPaperGaussians;
  Settings settings;
};

const char* const kAblations = "ablation"; // all of them

struct KnownExperiment {
  std::string name;
  std::string ablation = {}; // what it varies; "": it is no ablation
};

std::vector<KnownExperiment> knownExperiments() {
  std::vector<KnownExperiment> known{{"selection"}, {"contour"},  {"dynamic"},     {"text"},
                                     {"static"},    {kAblations}, {"segmentation"}};
  std::vector<std::string> varied = ablationNames();
  varied.push_back(kPrediction);
  for (const std::string& what : varied)
    known.push_back({"ablation-" + what, what});
  return known;
}

std::vector<std::string> knownNames(bool onlyAblations = false) {
  std::vector<std::string> names;
  for (const KnownExperiment& known : knownExperiments())
    if (!onlyAblations || !known.ablation.empty()) names.push_back(known.name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : "|") + name;
  return text;
}

/// The requested experiments, each once, in the order of knownExperiments(), as later ones reuse the fits of
/// earlier ones. Without labels, --all omits segmentation.
std::vector<KnownExperiment> chosenExperiments(const ExperimentOptions& o) {
  if (o.all && !o.names.empty()) throw CLI::ValidationError("experiment", "give names or --all, not both");
  if (!o.all && o.names.empty())
    throw CLI::ValidationError("experiment", "give one or more of " + joined(knownNames()) + ", or --all");
  const std::vector<std::string> known = knownNames();
  for (const std::string& name : o.names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw CLI::ValidationError("experiment", "'" + name + "' is not one of " + joined(known));
  const auto asked = [&](const std::string& name) {
    return o.all || std::find(o.names.begin(), o.names.end(), name) != o.names.end();
  };
  std::vector<KnownExperiment> chosen;
  for (const KnownExperiment& one : knownExperiments()) {
    if (one.name == kAblations || (o.all && one.name == "segmentation" && o.labels.empty())) continue;
    if (asked(one.name) || (!one.ablation.empty() && asked(kAblations))) chosen.push_back(one);
  }
  return chosen;
}

class Experiments {
public:
  Experiments(const ExperimentOptions& options, ProgressDisplay& display, std::stop_token stop)
      : o_(options), display_(display), stop_(std::move(stop)) {}

  void run(const KnownExperiment& experiment) {
    if (stop_.stop_requested()) throw Error(ErrorCode::Cancelled, "The experiments were cancelled.");
    if (experiment.ablation == kPrediction) return predictionAblation();
    if (!experiment.ablation.empty()) return ablation(experiment.ablation);
    static const std::map<std::string, void (Experiments::*)()> others{
        {"selection", &Experiments::selection},
        {"contour", &Experiments::contour},
        {"dynamic", &Experiments::dynamic},
        {"text", &Experiments::text},
        {"static", &Experiments::staticReconstruction},
        {"segmentation", &Experiments::segmentation}};
    (this->*others.at(experiment.name))();
  }

  /// Throws Error(Io) if a table or picture could not be written.
  void checkFiles() const { files_.check(); }

private:
  void selection() {
    display_.say("Candidate selection: simulation");
    SelectionSimulation simulation;
    simulation.seed = o_.settings.seed;
    if (o_.quick) simulation.clouds = 10, simulation.repetitions = 3;
    write(selectionTable(simulation, simulateSelections(simulation, o_.settings.instructionSet, stop_)));
  }

  void contour() {
    display_.say("Contours of the conditional splat");
    ContourCheck check;
    check.seed = o_.settings.seed;
    if (o_.quick) check.gaussians = 20;
    const ContourResult result = checkContours(check, stop_);
    write(contourTable(check, result));
    write("contour.png", contourPicture(result));
  }

  void dynamic() {
    DynamicExperiment experiment;
    if (o_.series.empty()) {
      JitteredPhantom phantom;
      if (o_.quick) phantom.geometry.size = {24, 24, 6}, phantom.frames = 10;
      experiment.series = makeJitteredPhantom(phantom);
    } else {
      experiment.series = readTimeSeries(o_.series);
    }
    experiment.name = experiment.series.name;
    experiment.settings.threads = o_.settings.threads;
    experiment.settings.instructionSet = o_.settings.instructionSet;
    experiment.settings.seed = o_.settings.seed;
    experiment.progress = [this](const Progress& progress) { display_.show(progress); };
    experiment.say = [this](const std::string& line) { display_.say(line); };
    experiment.stop = stop_;
    const DynamicExperimentResult result = runDynamic(experiment);
    write(result.methods);
    write(result.frames);
  }

  void text() {
    const Lexicon& lexicon = Lexicon::standard();
    ExperimentTable table;
    table.name = "text";
    table.title = "Queries in words, in a scene of TotalSegmentator's 117 classes";
    table.columns = {"phrases",       "by",           "naming_one", "top_1",          "top_3",
                     "wrong",         "side_flipped", "suggested",  "must_not_match", "false_accepts",
                     "any_suggested", "ms_a_phrase",  "ms_unread",  "slowest_ms",     "measured_on"};
    const auto started = std::chrono::steady_clock::now();
    const SentenceModel sentences = useTextModel(o_.textModel);
    const double loading = secondsSince(started);
    std::vector<std::shared_ptr<SentenceEmbedding>> embeddings{nullptr};
    if (sentences.embedding) embeddings.push_back(sentences.embedding);
    for (const auto& [name, json, on] :
         {std::tuple{"tuning", terminology::phrasesToTune(), "phrases tuned on"},
          {"unseen", terminology::phrasesToReport(), "phrases not tuned on"}}) {
      const PhraseSet set = phrasesFrom(lexicon, json);
      for (const auto& embedding : embeddings) {
        const PhraseReport r = reportOn(lexicon, set, embedding);
        const auto share = [](int part, int of) {
          return decimals(static_cast<double>(part) / std::max(1, of), 3);
        };
        const auto suggestions = [&](int part, int of) {
          return embedding ? fmt::format("{} of {}", part, of) : "";
        };
        table.add({name, embedding ? "lexicon and embedding" : "lexicon", std::to_string(r.named),
                   share(r.top1, r.named), share(r.top3, r.named), share(r.wrong, r.named),
                   std::to_string(r.flipped), suggestions(r.suggested, r.unanswered),
                   std::to_string(r.foreign), share(r.falseAccepts, r.foreign),
                   suggestions(r.foreignSuggested, r.foreign), decimals(r.milliseconds, 3),
                   decimals(r.unread, 3), decimals(r.slowest, 1), on});
        if (embedding != embeddings.back()) continue; // the last one's notes are enough
        for (const std::string& miss : r.misses)
          table.notes.push_back(std::string(name) + ", missed: " + miss);
      }
    }
    table.notes.push_back(
        sentences.embedding
            ? fmt::format("The embedding, loaded in {:.2f} s, suggests and never answers. suggested: what is "
                          "meant is among its first three, of the phrases without an answer; unread: "
                          "phrases beyond the lexicon; slowest: the first of them, which encodes the names "
                          "of the scene's segments.",
                          loading)
            : sentences.problem);
    table.notes.push_back("top 1: the leading candidates are exactly what is meant; wrong: they hold none of "
                          "it. Both sets were written before the lexicon, by the same author.");
    write(table);
  }

  void segmentation() {
    SegmentationExperiment experiment;
    experiment.volume = readVolume(o_.volume, {});
    experiment.volumeName = utf8(std::filesystem::path(o_.volume).filename());
    for (std::size_t n = 0; n < o_.labels.size(); ++n) {
      LabelSet set{
          utf8(std::filesystem::path(o_.labels[n]).filename()), labelmapOf(readVolume(o_.labels[n], {})), {}};
      set.names = readSegmentNames(n < o_.labelNames.size() ? o_.labelNames[n] : o_.labels[n]);
      experiment.sets.push_back(std::move(set));
    }
    if (o_.quick)
      experiment.training.iterations = 3, experiment.every = {1, 5}, experiment.settings.iterations = 3;
    experiment.settings.threads = o_.settings.threads;
    experiment.settings.device = o_.settings.device;
    experiment.settings.instructionSet = o_.settings.instructionSet;
    experiment.progress = [this](const Progress& progress) { display_.show(progress); };
    experiment.say = [this](const std::string& line) { display_.say(line); };
    experiment.stop = stop_;
    const SegmentationResult result = runSegmentation(experiment);
    write(result.methods);
    write(result.grids);
    write(result.queries);
    writeCsv(result.classes);
  }

  void staticReconstruction() {
    const StaticExperiment result = runStatic(fits());
    write(result.perPlane);
    write(result.held);
    write("static.png",
          staticPicture(result, fmt::format("{}, {} Gaussians at the start", fits().setup().volumeName,
                                            fits().setup().gaussians)));
  }

  void ablation(const std::string& name) {
    const Ablation result = runAblation(fits(), name);
    write(result.table);
    writeCsv(curvesOf(result));
    write(result.table.name + ".png", ablationChart(result, titleOf(result.title)));
  }

  void predictionAblation() {
    const PredictionAblation result = runPredictionAblation(fits().setup());
    write(result.table);
    write(result.table.name + ".png", predictionChart(result));
  }

  std::string titleOf(const std::string& what) { return what + ", " + fits().setup().volumeName; }

  /// Reads the volume when the first experiment needs it; all experiments share the fits.
  ExperimentFits& fits() {
    if (!fits_) {
      ExperimentSetup setup;
      setup.volume = readVolume(o_.volume, {});
      setup.volumeName = utf8(std::filesystem::path(o_.volume).filename());
      setup.papersVolume = isPapersVolume(setup.volumeName, setup.volume) && !o_.quick;
      if (o_.quick) {
        setup.volume = centralCrop(setup.volume, kQuickSize);
        setup.volumeName += " (a crop)";
      }
      setup.quick = o_.quick;
      setup.gaussians = o_.gaussians;
      setup.settings = o_.settings;
      setup.progress = [this](const Progress& progress) { display_.show(progress); };
      setup.say = [this](const std::string& line) { display_.say(line); };
      setup.stop = stop_;
      fits_.emplace(std::move(setup));
    }
    return *fits_;
  }

  std::filesystem::path folder() const { return o_.output; }

  void write(const ExperimentTable& table) {
    display_.finish();
    std::cout << textOf(table) << std::flush;
    writeCsv(table);
  }
  void writeCsv(const ExperimentTable& table) {
    files_.write(folder() / (table.name + ".csv"),
                 [&](const auto& path) { writeFileAtomically(path, csvOf(table)); });
  }
  void write(const std::string& name, const Picture& picture) {
    files_.write(folder() / name,
                 [&](const auto& path) { writePng(path, picture.width, picture.height, 3, picture.rgb); });
  }

  const ExperimentOptions& o_;
  ProgressDisplay& display_;
  std::stop_token stop_;
  std::optional<ExperimentFits> fits_;
  OutputFiles files_;
};

void makeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !std::filesystem::is_directory(path))
    throw Error(ErrorCode::Io, "Cannot make the folder '" + path + "': choose another --output.");
  checkOutputFolder(std::filesystem::path(path) / "table.csv");
}

int experiment(const ExperimentOptions& o) {
  const std::vector<KnownExperiment> chosen = chosenExperiments(o);
  const bool fits = std::any_of(chosen.begin(), chosen.end(), [](const auto& one) {
    return one.name != "selection" && one.name != "contour" && one.name != "text" && one.name != "dynamic";
  });
  const auto isSegmentation = [](const auto& one) { return one.name == "segmentation"; };
  if (std::any_of(chosen.begin(), chosen.end(), isSegmentation) && o.labels.empty())
    throw CLI::ValidationError("experiment", "segmentation needs --labels");
  if (fits && o.volume.empty())
    throw CLI::ValidationError("experiment", "static, the ablations and segmentation need --volume");
  Settings checked = o.settings;
  checked.gaussians = o.gaussians;
  checkSettings(checked);
  if (fits && !std::filesystem::exists(o.volume))
    throw Error(ErrorCode::FileNotFound, "There is no file '" + o.volume + "'.");
  makeFolder(o.output);

  ProgressDisplay display(o.quiet);
  Interrupt interrupt;
  Experiments experiments(o, display, interrupt.token());
  for (const KnownExperiment& one : chosen)
    experiments.run(one);
  display.finish();
  experiments.checkFiles();
  return Success;
}

} // namespace

Subcommand addExperiment(CLI::App& app) {
  auto* command =
      app.add_subcommand("experiment", "Reproduces the paper's tables, with its figures next to ours");
  auto o = std::make_shared<ExperimentOptions>();
  addOption(*command, "names", o->names, "NAME",
            "selection: simulation of the candidate selections\n"
            "contour: the conditional splat against the sliced 3D Gaussian\n"
            "dynamic: frames held out from a dynamic scan and interpolated\n"
            "static: every blending by the paper's and the held-out protocol\n"
            "text: queries in words, on two sets of phrases\n"
            "segmentation: labels of some slices propagated to the others\n"
            "ablation: the effect of each choice, or of one of them: " +
                joined(knownNames(true)));
  command->add_flag("--all", o->all, "All of them: 10 to 30 minutes on two cores");
  addOption(*command, "--volume", o->volume, "FILE",
            "The truth for static and the ablations (the paper's: BrainWeb T1); for segmentation, the\n"
            "labels' own scan");
  addOption(*command, "--series", o->series, "FILE",
            "Scan for dynamic: 4D NIfTI, .seq.nrrd or a folder [a phantom that jitters]");
  addOption(*command, "--labels", o->labels, "FILE ...", "Labelmaps of the volume, for segmentation");
  addOption(*command, "--label-names", o->labelNames, "FILE ...", "Their names, JSON, in the same order");
  addTextModel(*command, o->textModel);
  addOption(*command, "-o,--output", o->output, "FOLDER", "Folder for the tables (CSV) and pictures (PNG)")
      ->required();
  command->add_flag("--quick", o->quick, "A small crop and a few iterations: only shows that it runs");
  addOption(*command, "--gaussians", o->gaussians, "N",
            "Gaussians at the start of a fit [74088, the paper's]");
  addSetting(*command, o->settings, "seed", "Seed of held-out slices, starts and simulations [1]");
  for (const char* name : {"threads", "device", "instructionSet"})
    addSetting(*command, o->settings, name);
  command->add_flag("-q,--quiet", o->quiet, "No progress; the tables only");
  command->footer("Tables go to the standard output and, as CSV, to the folder; Docs/experiments.md explains "
                  "them.\n"
                  "Examples:\n"
                  "  innergs experiment selection contour --output results\n"
                  "  innergs experiment dynamic --series wrist.nii.gz --output results\n"
                  "  innergs experiment static --volume t1.nii.gz --output results\n"
                  "  innergs experiment --all --volume brainweb_t1_145x174x145.nii.gz --output results");
  return {command, [o] { return experiment(*o); }};
}

} // namespace innergs::cli
