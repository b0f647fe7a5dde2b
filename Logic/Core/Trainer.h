#pragma once
#include "Core/Densify.h"
#include "Core/Initialise.h"
#include "Core/Loss.h"

#include <limits>
#include <memory>

namespace innergs {

/// Everything that a fit does, as numbers: a function of preset and data (Plan.h), never of the machine.
struct FitPlan {
  InitialisationPlan start;
  bool linearIntensity = false;
  int iterations = 200;
  int coarseIterations = 0;       // the first ones see the data at half resolution
  bool smoothAlongNormal = false; // see observe()
  LossKinds loss;
  LearningRates rates; // at the start
  Schedule schedule = Schedule::Exponential;
  double finalRate = 0.05; // rates decay exponentially to this share
  PlateauRule plateau;
  double cutoff = 2.2; // Mahalanobis radius
  FieldBounds bounds;
  double beta1 = 0.9, beta2 = 0.99;
  int relocateEvery = 0;       // 0 = never
  double relocateShare = 0.02; // of the Gaussians, each time
  double relocateUntil = 0.6;  // share of the iterations
  DensifyPlan densify;
  bool allAxes = false; // see Settings
  bool paperStopRule = false;
};

/// How learning rates fall when the loss stops improving: a function of the losses so far.
class PlateauSchedule {
public:
  void add(double loss, const PlateauRule& rule);
  double share() const { return share_; } // of the first rates

private:
  double best_ = std::numeric_limits<double>::infinity(), share_ = 1;
  int waited_ = 0;
};

/// Fits a field to observations, one sweep over all of them at a time. State after n sweeps depends on the
/// inputs and n alone.
class Trainer {
public:
  Trainer(GaussianField field, std::vector<Observation> observations, FitPlan plan, const KernelSet& kernels,
          ThreadPool& pool);
  ~Trainer();

  /// Starts again with another field on the same observations.
  void restart(GaussianField field);

  /// Continues from a saved state; without its losses, stop rule and plateau schedule start anew.
  void restore(std::vector<float> moment1, std::vector<float> moment2, int iteration,
               std::span<const float> losses = {}, std::vector<float> pulls = {});

  /// One sweep: forward, loss, gradient, Adam step. False when finished. When the pool is stopped in between,
  /// throws Error(Cancelled) and leaves the state as it was.
  bool step();

  bool finished() const;
  int iteration() const { return iteration_; }
  const GaussianField& field() const { return field_; }
  const Adam& adam() const { return adam_; }
  double loss() const { return loss_; }                          // mean per sample, last sweep
  double mse() const { return mse_; }                            // last sweep, normalised intensity²
  const std::vector<float>& losses() const { return history_; }  // mean per sample, of every sweep
  const std::vector<float>& pulls() const { return pulls_.sum; } // since the last densification
  const DensifyCounts& densified() const { return densified_; }  // so far

  /// Loss of any field on the observations, nothing changed.
  LossSum evaluate(const GaussianField& field);

private:
  void record(float loss);
  double rateShare() const;
  bool densifying() const;
  void reshape();

  struct View {
    Observation observation;
    std::unique_ptr<LatticeRenderer> renderer;
  };
  std::vector<View>& activeViews();

  GaussianField field_;
  FitPlan plan_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  Adam adam_;
  std::vector<View> fine_, coarse_;
  std::vector<float> weights_, numerators_, gradient_;
  std::vector<float> history_; // losses, for the stop rule
  PlateauSchedule plateau_;
  PullSum pulls_;
  DensifyCounts densified_;
  int iteration_ = 0;
  double loss_ = 0, mse_ = 0;
};

} // namespace innergs
