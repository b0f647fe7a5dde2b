#pragma once
#include "Core/Acquisition/BackProjection.h"
#include "Core/Fit/Plan.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/ProgressParts.h"
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

/// The steps of a reconstruction: for ReconstructionJob's own sources.
namespace innergs {

constexpr double kPredictionEnds = 0.5;                                    // where there is one
constexpr double kFitStarts = 0.03, kFitEnds = 0.92, kResidualEnds = 0.97; // of the progress bar

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Reconstructions that run in this process now.
int runningJobs();

constexpr double kMostFieldVoxels = 10e6; // of a prediction that a field fitted to the slices takes part in

/// Of the field, fitted to the slices alone, that takes part in a prediction.
inline Settings fieldSettings(const Settings& settings) {
  Settings field;
  field.preset = settings.preset == Preset::Best ? Preset::Balanced : Preset::Fast;
  field.prediction = PredictionKind::None;
  field.ensembleSize = 1;
  field.consistency = settings.consistency;
  field.threads = settings.threads;
  field.instructionSet = settings.instructionSet;
  field.device = settings.device;
  field.seed = settings.seed;
  return field;
}

/// dB, of a mean squared error in normalised intensity.
inline double psnrOf(double mse) {
  return mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity();
}

struct ReconstructionJob::Impl {
  ReconstructionInput input;
  Settings settings;
  ProgressCallback progress;
  std::function<void(const Volume&)> preview;

  std::chrono::steady_clock::time_point start;
  Progress state;
  double nextPreview = 1.0;

  void report(Phase phase, double fraction) {
    state.phase = phase;
    state.fraction = std::max(state.fraction, fraction);
    state.elapsed = secondsSince(start);
    state.remaining = state.fraction > 0.02 ? state.elapsed * (1 - state.fraction) / state.fraction : 0;
    if (progress) progress(state);
  }

  /// A report that says where the fit runs.
  void reportDevice(Phase phase) {
    state.note = device->use.reason;
    report(phase, state.fraction);
    state.note.clear();
  }

  RenderOptions renderOptions(const GaussianField& field, std::stop_token stop) {
    RenderOptions options;
    options.threads = settings.threads;
    options.instructionSet = settings.instructionSet;
    options.selection = settings.selection;
    options.device = device->makeField(field, stop);
    options.stop = std::move(stop);
    return options;
  }

  ReconstructionResult run(std::stop_token stop, bool renderWhenCancelled);
  void choose(const PreparedInput& prepared, ThreadPool& pool, ReconstructionResult& result);
  ReconstructionResult fieldAlone(const Stack& stack, const GridGeometry& grid, const std::stop_token& stop,
                                  double from, double to);
  void anchor(Volume& guess, const Stack& scan, const CandidateChoice& choice, ThreadPool& pool) const;
  struct Further {
    std::optional<Volume> field, learned;
    std::vector<std::uint8_t> known; // voxels that were learned; empty: all
    std::string sentence;            // of the learning
  };
  Further furtherCandidates(const Stack& scan, const GridGeometry& grid, const CandidateChoice& choice,
                            const Further& wanted, bool trial, ThreadPool& pool, double from, double to);
  struct Added {                   // to the interpolation
    double field = 0, learned = 0; // shares
    std::string nothingLearned;    // a sentence
  };
  Added addCandidates(const Stack& scan, const CandidateChoice& choice, ThreadPool& pool);
  void predict(const PreparedInput& prepared, ThreadPool& pool, ReconstructionResult& result);
  void keepPrediction(const PreparedInput& prepared, ThreadPool& pool, ReconstructionResult& result);
  /// What Gaussians are fitted to: the stacks, or the prediction from the only one.
  std::span<const Stack> fittedStacks(const PreparedInput& prepared) const {
    return predicted ? std::span<const Stack>(fitted) : prepared.stacks;
  }
  /// And what they start on.
  std::span<const Stack> startedStacks(const PreparedInput& prepared, std::vector<Stack>& bridged) const {
    return predicted ? std::span<const Stack>(fitted) : startStacks(prepared, bridged);
  }
  void setPlace(GaussianField& field, const PreparedInput& prepared) const;
  GaussianField startField(const PreparedInput& prepared, int member, ThreadPool& pool);
  void fit(const PreparedInput& prepared, const KernelSet& kernels, ThreadPool& pool,
           ReconstructionResult& result);
  std::unique_ptr<FitDevice> place(const FitRequest& request, ReconstructionResult& result);
  void noticeFailure(const Trainer& trainer, int before, ReconstructionResult& result);
  void iterate(Trainer& trainer, const GridGeometry& grid, int before, ThreadPool& pool,
               ReconstructionResult& result);
  std::int64_t coverLimit(std::int64_t gaussians) const;
  void coverMask(const PreparedInput& prepared, ThreadPool& pool);
  void addResidual(const PreparedInput& prepared, ThreadPool& pool, ReconstructionResult& result);
  void scoreHeldOut(const PreparedInput& prepared, const GaussianField& field, const RenderOptions& options,
                    ReconstructionResult& result) const;
  /// The result's quality, by a second fit with these settings.
  void judge(ReconstructionResult& result, const Settings& asked, const ProgressCallback& told,
             const std::stop_token& stop);

  /// A model to resume that was stopped after its first Gaussians and by another fit than this one.
  bool refits() const {
    return input.resume && !input.resume->field.gaussians.empty() && input.resume->settingsKey != key;
  }

  bool predicted = false;    // what lies between the slices
  std::vector<Stack> fitted; // the prediction as thin slices
  bool withheld = false;     // this is the second fit
  IntensityMap map;
  DataTraits traits;
  FitPlan plan;
  std::optional<DeviceChoice> device;
  std::string key;
  bool refitting = false; // the model to resume is the start of another fit
  Model model;            // of this run; its field holds the finished members
};

} // namespace innergs
