#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Densify.h"
#include "Core/Fit/Loss.h"
#include "Core/Fit/Relocate.h"

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

namespace innergs {

/// The parameters of one iteration.
struct IterationOptions {
  bool coarse = false;              // uses the data at half resolution
  int subset = -1;                  // uses the observations of this subset; below 0: all
  bool accumulateGradients = false; // adds each Gaussian's positional gradient to the sums for densify()
  LearningRates rates;              // of this iteration
  int step = 1;                     // of Adam, from 1
  std::optional<RelocationPlan> relocate; // once the parameters are updated
};

/// The parameters that stay constant over a fit.
struct FitRules {
  LossKinds loss;
  FieldBounds bounds;
  double beta1 = 0.8, beta2 = 0.95;
  DensifyPlan densify;
};

/// A fit to run on a device.
struct FitRequest {
  std::shared_ptr<const std::vector<Observation>> observations; // at full resolution
  bool coarse = false; // some iterations will run at half resolution, on coarsened() observations
  FitRules rules;
  Blending blending = Blending::Normalised;
  bool linearIntensity = false;
  int iterations = 0;         // planned in total; 0: unknown
  std::int64_t gaussians = 0; // the largest number that the fit or a field to evaluate will have
  std::stop_token stop;       // makes iterate() and gradient() throw Error(Cancelled)
};

/// The state that iterations change.
struct FitState {
  GaussianField field;
  Adam adam{0};
  GradientAccumulator accumulator;
};

/// Runs the iterations of a fit: holds observations, field, Adam's moments and gradients, and returns them on
/// request. A call that throws either has changed nothing or makes the next download() throw as well. The
/// plain CPU is the reference: every other device agrees with it to 1e-4 relative.
class FitDevice {
public:
  virtual ~FitDevice() = default;

  /// Sets the field to fit, Adam's moments (zeros at the start) and gradients.
  virtual void upload(const GaussianField& field, const Adam& adam,
                      const GradientAccumulator& accumulator) = 0;
  /// Returns the current state of what upload() set; skips null pointers.
  virtual void download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) = 0;

  /// upload() that takes ownership of the state.
  virtual void take(FitState&& state) {
    upload(state.field, state.adam, state.accumulator);
    state = {};
  }
  /// The state, if it lies in host memory anyway: like download(), without a copy. Otherwise null.
  virtual const FitState* resident() const { return nullptr; }

  /// Forward, loss, gradient, Adam, relocation. If stopped in between, throws Error(Cancelled) and leaves
  /// field and moments unchanged. Throws Error(Memory) if device memory runs out, likewise.
  virtual LossSum iterate(const IterationOptions& options) = 0;
  /// Runs several iterations, at least the first, waiting only once for all their sums. If stopped or failing
  /// after the first, returns the sums of those completed.
  virtual std::vector<LossSum> iterateMany(std::span<const IterationOptions> iterations) {
    return {iterate(iterations.front())};
  }
  virtual DensifyCounts densify() = 0;

  /// Loss of any field on the full-resolution observations; changes nothing.
  virtual LossSum evaluate(const GaussianField& field) = 0;
  /// The same on one observation, with its gradient if that is not empty: becomes dL/d(parameters) of every
  /// Gaussian, 16 floats each in the order of struct Gaussian.
  virtual LossSum gradient(const GaussianField& field, std::int64_t observation,
                           std::span<float> gradient) = 0;

  /// One sentence about the run for the user; empty: nothing special.
  virtual std::string remark() const { return {}; }
};

} // namespace innergs
