#include "Evaluation/ExperimentPrediction.h"

#include "Core/Base/Error.h"
#include "Core/Image/BodyMask.h"
#include "Core/Job/PredictionPlan.h"
#include "Evaluation/BackProjectionBaseline.h"
#include "Evaluation/Baselines.h"
#include "Evaluation/EvaluationRuns.h"
#include "Evaluation/HeldOutProtocol.h"

#include <algorithm>

namespace innergs {
namespace {

struct AblationCase {
  HeldOutCase heldOut;
  const char *name, *title, *measuredOn;
};
const AblationCase kCases[] = {
    {{HeldOutCase::Kind::KeepEvery, 4, 2, 0}, "every-4th", "every 4th slice", "held-out slices (H)"},
    {{HeldOutCase::Kind::Thick, 4, 2, 0}, "thick-4", "4 voxels thick", "thin slices, none seen (H)"}};

constexpr const char *kInterpolation = "interpolation", *kAlone = "part alone", *kWhole = "whole";

/// Runs the methods of one case and scores them alike.
class CaseRun {
public:
  CaseRun(const ExperimentSetup& setup, const AblationCase& c)
      : setup_(setup), thick_(c.heldOut.kind == HeldOutCase::Kind::Thick),
        input_(heldOutInput(setup.volume, c.heldOut, setup.settings.seed)),
        mask_(bodyMask(input_.truth, setup.stop)), peak_(intensityRange(input_.truth)) {
    result_.name = c.name;
    result_.title = c.title;
    options_.stop = setup.stop;
    options_.onMethod = [&setup, title = result_.title](const std::string& method) {
      if (setup.say) setup.say("Prediction, " + title + ": " + method);
    };
    settings_ = setup.settings;
    settings_.preset = setup.quick ? Preset::Fast : Preset::Balanced;
  }

  PredictionAblation::Case run() {
    interpolations();
    learnedAlone("linear filter alone", PredictionEffort::Filter, true);
    const PredictionEffort effort = setup_.quick ? PredictionEffort::Fast : PredictionEffort::Balanced;
    learnedAlone("network alone", effort, true);
    learnedAlone("network alone, from random weights", effort, false);
    reconstruction("field alone, as a candidate", kAlone, fieldSettings(settings_));
    Settings changed = settings_;
    changed.prediction = PredictionKind::Interpolation;
    reconstruction("mixture of interpolations alone", kAlone, changed);
    changed.prediction = PredictionKind::None;
    reconstruction("no prediction: several fields merged", kWhole, changed);
    reconstruction("everything", kWhole, settings_);
    reconstruction("everything but the field", kWhole, settings_, {.field = false});
    reconstruction("everything but learning", kWhole, settings_, {.learned = false});
    reconstruction("everything, from random weights", kWhole, settings_, {.startWeights = false});
    changed = settings_;
    changed.consistency = false;
    reconstruction("everything, no residual grid", kWhole, changed);
    return std::move(result_);
  }

private:
  /// A method that returns no volume does not apply to the scan.
  void add(const std::string& label, const char* family, const std::function<Volume()>& method) {
    const TimedVolume run = runMethod(label, options_, method);
    PredictionAblation::Row row{label, family, {}, run.seconds, run.cpuSeconds};
    if (!run.volume->voxels.empty())
      row.quality = pooledQuality(*run.volume, input_.truth, mask_, peak_, input_.testSlices, setup_.stop);
    result_.rows.push_back(std::move(row));
  }

  void interpolations() {
    const int threads = settings_.threads;
    const GridGeometry& grid = input_.truth.geometry;
    for (const auto& [label, kind] :
         {std::pair{"linear", Interpolation::Linear}, std::pair{"cubic", Interpolation::Cubic},
          std::pair{"Lanczos", Interpolation::Lanczos}})
      add(label, kInterpolation,
          [&, kind = kind] { return averageUpsampled(input_.stacks, grid, kind, threads, setup_.stop); });
    if (!thick_) return;
    add("back-projection", kInterpolation, [&] {
      return backProjectionBaseline(input_.stacks, grid, {.threads = threads, .stop = setup_.stop});
    });
  }

  /// What is learned, without Gaussians.
  void learnedAlone(const std::string& label, PredictionEffort effort, bool startWeights) {
    add(label, kAlone, [&] {
      PredictionOptions options;
      options.effort = effort;
      options.grid = input_.truth.geometry;
      options.fromScratch = !startWeights;
      options.seed = settings_.seed;
      options.instructionSet = settings_.instructionSet;
      ThreadPool pool(settings_.threads);
      pool.setStop(setup_.stop);
      return predictAcrossSlices(input_.stacks.front(), options, pool).image;
    });
  }

  void reconstruction(const std::string& label, const char* family, const Settings& settings,
                      PredictionParts parts = {}) {
    add(label, family, [&] {
      ReconstructionInput input;
      input.stacks = input_.stacks;
      input.outputGrid = input_.truth.geometry;
      input.predictionParts = parts;
      ReconstructionJob job(std::move(input), settings);
      if (setup_.progress) job.onProgress(setup_.progress);
      ReconstructionResult result = job.run(setup_.stop);
      if (result.cancelled) throw Error(ErrorCode::Cancelled, "The experiments were cancelled.");
      return std::move(result.volume);
    });
  }

  const ExperimentSetup& setup_;
  const bool thick_;
  const EvaluationInput input_;
  const std::vector<std::uint8_t> mask_;
  const double peak_;
  EvaluationOptions options_;
  Settings settings_;
  PredictionAblation::Case result_;
};

/// dB of the best interpolation.
double bestInterpolation(const PredictionAblation::Case& c) {
  double best = -INFINITY;
  for (const PredictionAblation::Row& row : c.rows)
    if (row.family == kInterpolation) best = std::max(best, row.quality->psnr);
  return best;
}

} // namespace

PredictionAblation runPredictionAblation(const ExperimentSetup& setup) {
  PredictionAblation result;
  ExperimentTable& table = result.table;
  table.name = "ablation-prediction";
  table.title = "Ablation: parts of the prediction between slices, " + setup.volumeName;
  table.columns = {"case", "part",    "family",      "psnr_db",    "over_best_interpolation_db",
                   "ssim", "seconds", "cpu_seconds", "measured_on"};
  for (const AblationCase& c : kCases) {
    result.cases.push_back(CaseRun(setup, c).run());
    const PredictionAblation::Case& done = result.cases.back();
    const double best = bestInterpolation(done);
    for (const PredictionAblation::Row& row : done.rows) {
      const auto figure = [&](double value, int digits) {
        return row.quality ? decimals(value, digits) : std::string();
      };
      const Quality quality = row.quality.value_or(Quality{});
      table.add({done.title, row.label, row.family, figure(quality.psnr, 2), figure(quality.psnr - best, 2),
                 figure(quality.ssim, 4), decimals(row.seconds, 1), decimals(row.cpuSeconds, 1),
                 c.measuredOn});
    }
  }
  table.notes = {
      "PSNR and SSIM are pooled over the truth's body, which also says which interpolation is best.",
      "Filter and network alone: the volume as learned, without Gaussians, not anchored to slices.",
      "Mixture alone: --prediction interpolation. No prediction: --prediction none.",
      "From random weights: the networks do not start from weights learned on other scans.",
      "No residual grid: --no-consistency, which also omits the back-projection of thick slices.",
      std::string("Preset ") + (setup.quick ? "fast" : "balanced") +
          ". CPU seconds are those of all threads."};
  return result;
}

} // namespace innergs
