#pragma once
#include "Core/Fit/FitDevice.h"
#include "Core/Fit/Initialise.h"
#include "Core/Model/OptimizerState.h"
#include "Core/Render/Kernels.h"

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

/// The fit of a field to observations as a device needs to know it. `gaussians`: the most that it will hold
/// at once; 0: as many as the field, or as densification may reach.
FitRequest fitRequest(std::vector<Observation> observations, const FitPlan& plan, const GaussianField& field,
                      std::stop_token stop, std::int64_t gaussians = 0);

/// Fits a field to observations, one iteration over all of them at a time, on any device. State after n
/// iterations depends on the inputs, n and the kind of device alone. When another device than the CPU fails,
/// the fit goes on on the CPU: from the state that it had or, when that was lost with the device, from the
/// one that was last asked for.
class Trainer {
public:
  Trainer(GaussianField field, std::vector<Observation> observations, FitPlan plan, const KernelSet& kernels,
          ThreadPool& pool);
  /// device: made for the request; null: the CPU.
  Trainer(GaussianField field, FitRequest request, FitPlan plan, const KernelSet& kernels, ThreadPool& pool,
          std::unique_ptr<FitDevice> device);
  ~Trainer();

  /// Starts again with another field on the same observations.
  void restart(GaussianField field);

  /// Continues from a saved state; without its losses, stop rule and plateau schedule start anew.
  void restore(OptimizerState state, int iteration);

  /// One iteration: forward, loss, gradient, Adam step. False when finished. When the pool is stopped in
  /// between, throws Error(Cancelled) and leaves the state as it was. `most`: a device that keeps its own
  /// state may do that many before it waits, unless a loss decides how the fit goes on; the state is the
  /// same.
  bool step(int most = 1);

  bool finished() const;
  int iteration() const { return iteration_; }
  /// What the fit has reached, fetched from the device: ask for these before iteration() and the like.
  const GaussianField& field() { return state().field; }
  const Adam& adam() { return state().adam; }
  const std::vector<float>& gradients() { return state().accumulator.sum; } // since the last densification
  OptimizerState optimizer() { return {adam().moment1, adam().moment2, losses(), gradients()}; }
  std::int64_t gaussians() const { return gaussians_; }
  double loss() const { return loss_; }                         // mean per sample, last iteration
  double mse() const { return mse_; }                           // last iteration, normalised intensity²
  const std::vector<float>& losses() const { return history_; } // mean per sample, of every iteration
  const DensifyCounts& densified() const { return densified_; } // so far

  /// Loss of any field on the observations, nothing changed.
  LossSum evaluate(const GaussianField& field);

  /// Why the fit left its device for the CPU: the device's own sentence; empty: it did not.
  const std::string& failure() const { return failure_; }
  /// FitDevice's.
  std::string remark() const { return device_->remark(); }

private:
  void record(float loss);
  double rateShare(int iteration) const;
  bool densifying() const { return densifying(iteration_); }
  bool densifying(int iteration) const;
  bool densifies(int iterations) const;
  IterationOptions options(int iteration) const;
  void iterate(int most);
  void densify();
  const FitState& state();
  void upload();
  void mark();
  template <class Work>
  bool guarded(const Work& work);
  bool moveToCpu(const std::string& why);
  void rollBack();

  FitPlan plan_;
  FitRequest request_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  std::unique_ptr<FitDevice> device_;
  bool onCpu_ = true;
  std::string failure_;

  // In host memory: the state before the first iteration, and with a device that keeps its own also the last
  // that was fetched.
  FitState state_;
  bool uploaded_ = false; // the device has a state
  bool fresh_ = true;     // state_ is the device's
  struct Mark {           // what belongs to state_
    int iteration = 0;
    std::size_t losses = 0;
    DensifyCounts densified;
  } mark_;

  std::vector<float> history_; // losses, for the stop rule
  PlateauSchedule plateau_;
  DensifyCounts densified_;
  std::int64_t gaussians_ = 0;
  int iteration_ = 0;
  double loss_ = 0, mse_ = 0;
};

} // namespace innergs
