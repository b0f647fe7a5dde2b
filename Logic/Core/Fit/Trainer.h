#pragma once
#include "Core/Fit/FitPlan.h"
#include "Core/Fit/PlateauSchedule.h"
#include "Core/Model/OptimizerState.h"
#include "Core/Render/Kernels.h"

#include <memory>

namespace innergs {

/// Describes a fit of a field to observations to a device. `gaussians`: the most that it will hold at once;
/// 0: as many as the field has, or as densification may reach.
FitRequest fitRequest(std::vector<Observation> observations, const FitPlan& plan, const GaussianField& field,
                      std::stop_token stop, std::int64_t gaussians = 0);

/// Fits a field to observations, one iteration over all of them or over the next subset at a time, on any
/// device. The state after n iterations depends only on the inputs, n and the kind of device. If a device
/// other than the CPU fails, the fit continues on the CPU: from its current state or, if that was lost with
/// the device, from the state last fetched.
class Trainer {
public:
  Trainer(GaussianField field, std::vector<Observation> observations, FitPlan plan, const KernelSet& kernels,
          ThreadPool& pool);
  /// device: made for the same request; null: the CPU.
  Trainer(GaussianField field, FitRequest request, FitPlan plan, const KernelSet& kernels, ThreadPool& pool,
          std::unique_ptr<FitDevice> device);
  ~Trainer();

  /// Restarts with another field on the same observations.
  void restart(GaussianField field);

  /// Resumes from a saved state; without its losses, stop rule and plateau schedule restart.
  void restore(OptimizerState state, int iteration);

  /// Runs one iteration: forward, loss, gradient, Adam step. Returns false when finished. If the pool is
  /// stopped in between, throws Error(Cancelled) and leaves the state unchanged. `most`: a device with its
  /// own state may run that many iterations before it synchronises, unless a loss decides how the fit
  /// continues; the resulting state is the same.
  bool step(int most = 1);

  bool finished() const;
  int iteration() const { return iteration_; }
  /// The current state, fetched from the device. Call these before iteration() and the like.
  const GaussianField& field() { return state().field; }
  const Adam& adam() { return state().adam; }
  const std::vector<float>& gradients() { return state().accumulator.sum; } // since the last densification
  OptimizerState optimizer() { return {adam().moment1, adam().moment2, losses(), gradients()}; }
  std::int64_t gaussians() const { return gaussians_; }
  double loss() const { return loss_; } // mean per sample, last iteration, or last of each subset
  double mse() const { return mse_; }   // likewise, normalised intensity²
  const std::vector<float>& losses() const { return history_; } // mean per sample and iteration
  const DensifyCounts& densified() const { return densified_; } // so far

  /// Loss of any field on the observations; changes nothing.
  LossSum evaluate(const GaussianField& field);

  /// The device's own sentence on why the fit moved to the CPU; empty if it did not.
  const std::string& failure() const { return failure_; }
  /// See FitDevice.
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

  // In host memory: the state before the first iteration or, with a device that has its own, the last one
  // fetched.
  FitState state_;
  bool uploaded_ = false; // the device has a state
  bool fresh_ = true;     // state_ matches the device's
  struct Mark {           // belongs to state_
    int iteration = 0;
    std::size_t losses = 0;
    DensifyCounts densified;
  } mark_;

  std::vector<float> history_;  // losses, for the stop rule
  std::vector<LossSum> recent_; // the last of each subset of the observations
  PlateauSchedule plateau_;
  DensifyCounts densified_;
  std::int64_t gaussians_ = 0;
  int iteration_ = 0;
  double loss_ = 0, mse_ = 0;
};

} // namespace innergs
