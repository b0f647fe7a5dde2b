#pragma once
#include "Core/Device/Devices.h"
#include "Core/Fit/Plan.h"
#include "Core/Fit/Trainer.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/JobProgress.h"
#include "Core/Job/ResidualRefinement.h"
#include "Core/Job/ScanCorrection.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/Render.h"

namespace innergs {

/// The number of reconstructions currently running in this process.
int runningJobs();

/// One fit of a model to its input, with the prediction before it, the refinement after it and its volume. A
/// job makes one, and a second one to judge its quality.
class ReconstructionRun {
public:
  /// The input must outlive the run. heldOut: leaves out the slices selected by heldOutFraction, and scores
  /// the result on them.
  ReconstructionRun(const ReconstructionInput& input, const Settings& settings, bool heldOut,
                    ProgressCallback progress, std::function<void(const Volume&)> preview = {});
  ~ReconstructionRun();

  /// ReconstructionJob::run() without judging the quality.
  ReconstructionResult run(const std::stop_token& stop, bool renderWhenCancelled);

  /// Before run(): also keeps what is seen of held-out slices, for takeHeldOutValues().
  void keepHeldOutValues() { keepsValues_ = true; }
  /// Before run(): where each of several scans predicts, the predictions get this share instead of one chosen
  /// by simulation.
  void setPredictionShare(double share) { share_ = share; }
  /// Before run(): slices with poses are fitted like those that were moved, not like tracked ones.
  void treatPosesAsFound() { posesFound_ = true; }
  /// Before run(): also keeps the volume without these predictions, for takeUnmixed().
  void keepUnmixed() { keepsUnmixed_ = true; }
  Volume takeUnmixed() { return std::move(unmixed_); }

  /// After run(): the stacks as they were fitted, and what was seen of held-out slices.
  std::vector<Stack> takeStacks() { return std::move(prepared_.stacks); }
  std::vector<HeldOutValue> takeHeldOutValues() { return std::move(heldOutValues_); }

private:
  void choose();
  Volume fieldAlone(const Stack& stack, const GridGeometry& grid, const Settings& settings, double from,
                    double to);
  std::span<const Stack> fittedStacks() const;
  std::span<const Stack> startedStacks(std::vector<Stack>& bridged) const;
  void setPlace(GaussianField& field) const;
  GaussianField startField(int member);
  std::vector<Observation> observations(const GaussianField& field) const;
  std::unique_ptr<FitDevice> place(const FitRequest& request);
  double fromFit(double share) const;
  void fit();
  void iterate(Trainer& trainer, int before);
  void noticeFailure(const Trainer& trainer, int before);
  std::int64_t coverLimit(std::int64_t gaussians) const;
  void coverMask();
  void addResidual();
  void mixPredictions(const RenderOptions& options);
  std::optional<double> chooseShare(const RenderOptions& options);
  std::vector<Stack> predictEach();
  void renderResult(const std::stop_token& stop);
  void scoreHeldOut(const RenderOptions& options);
  void compareWithScans(const RenderOptions& options);
  RenderOptions renderOptions(const GaussianField& field, std::stop_token stop);
  /// Reports where the fit runs.
  void reportDevice();
  void setTrainingPsnr(double psnr) { result_.trainingPsnr = progress_.state.trainingPsnr = psnr; }

  const ReconstructionInput& input_;
  Settings settings_, asked_;
  const bool heldOut_;
  bool keepsValues_ = false, keepsUnmixed_ = false, posesFound_ = false;
  std::optional<double> share_; // of predictions from each scan
  Volume unmixed_;
  JobProgress progress_;
  std::function<void(const Volume&)> preview_;
  double nextPreview_ = 1.0; // seconds

  PreparedInput prepared_;
  std::vector<HeldOutValue> heldOutValues_;
  std::unique_ptr<ThreadPool> pool_;
  std::optional<ScanCorrection> correction_;
  const KernelSet* kernels_ = nullptr;
  std::optional<DeviceChoice> device_;
  IntensityMap map_;
  DataTraits traits_;
  FitPlan plan_;
  std::string key_;
  double fitStarts_ = 0;                   // fraction of the progress
  bool refitting_ = false;                 // the model to resume starts another fit
  std::optional<Stack> predicted_;         // what lies between the slices, as thin slices
  double predictionNoise_ = 0;             // of the scans, without what their slices share; scanner units
  std::optional<WeightedVolume> averaged_; // with it, its noise removed
  bool predictsEach_ = false;              // or what lies between those of each is mixed in after the fit
  Model model_;                            // its field holds the finished members
  ReconstructionResult result_;
};

} // namespace innergs
