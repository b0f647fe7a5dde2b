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

/// The numbers of one iteration.
struct IterationOptions {
  bool coarse = false; // see the data at half resolution
  bool accumulateGradients =
      false;           // add every Gaussian's positional gradient to the sums that densify() looks at
  LearningRates rates; // of this iteration
  int step = 1;        // of Adam, from 1
  std::optional<RelocationPlan> relocate; // once the parameters are updated
};

/// What stays the same over the iterations of a fit.
struct FitRules {
  LossKinds loss;
  FieldBounds bounds;
  double beta1 = 0.8, beta2 = 0.95;
  DensifyPlan densify;
};

/// A fit to be run on a device.
struct FitRequest {
  std::shared_ptr<const std::vector<Observation>> observations; // at full resolution
  bool coarse = false; // iterations at half resolution will be asked for: on coarsened() observations
  FitRules rules;
  Blending blending = Blending::Normalised;
  bool linearIntensity = false;
  int iterations = 0;         // planned, in all; 0: not known
  std::int64_t gaussians = 0; // the most that upload(), densify() or evaluate() will see
  std::stop_token stop;       // what makes iterate() throw Error(Cancelled)
};

/// What the iterations of a fit change.
struct FitState {
  GaussianField field;
  Adam adam{0};
  GradientAccumulator accumulator;
};

/// Where the iterations of a fit run: holds observations, field, Adam's moments and gradients, and gives them
/// back when asked. A call that throws has changed nothing, or makes the next download() throw as well. The
/// plain CPU is the oracle: any other device computes the same to 1e-4 relative.
class FitDevice {
public:
  virtual ~FitDevice() = default;

  /// The field to fit and Adam's moments (zeros at the start) and gradients.
  virtual void upload(const GaussianField& field, const Adam& adam,
                      const GradientAccumulator& accumulator) = 0;
  /// What upload() gave, as it is now. Whatever is null is left out.
  virtual void download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) = 0;

  /// upload() of a state that the caller gives away.
  virtual void take(FitState&& state) {
    upload(state.field, state.adam, state.accumulator);
    state = {};
  }
  /// The state where it lies in host memory anyway: the same as download(), without the copy. Else null.
  virtual const FitState* resident() const { return nullptr; }

  /// Forward, loss, gradient, Adam, relocation. Stopped in between: throws Error(Cancelled) and leaves field
  /// and moments as they were. Out of device memory: Error(Memory), likewise.
  virtual LossSum iterate(const IterationOptions& options) = 0;
  /// Several iterations that nobody needs to look at in between, at least the first: a device waits for their
  /// sums together. Stopped or failing after the first: the sums of those that were done.
  virtual std::vector<LossSum> iterateMany(std::span<const IterationOptions> iterations) {
    return {iterate(iterations.front())};
  }
  virtual DensifyCounts densify() = 0;

  /// Loss of any field on the observations at full resolution, nothing changed.
  virtual LossSum evaluate(const GaussianField& field) = 0;

  /// One sentence on how it runs that a person should know; empty: nothing special.
  virtual std::string remark() const { return {}; }
};

} // namespace innergs
