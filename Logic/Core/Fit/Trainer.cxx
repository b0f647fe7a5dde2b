#include "Core/Fit/Trainer.h"

#include "Core/Base/Error.h"
#include "Core/Fit/CpuFitDevice.h"

#include <algorithm>
#include <cmath>

namespace innergs {

FitRequest fitRequest(std::vector<Observation> observations, const FitPlan& plan, const GaussianField& field,
                      std::stop_token stop, std::int64_t gaussians) {
  FitRequest request;
  request.observations = std::make_shared<const std::vector<Observation>>(std::move(observations));
  request.coarse = plan.coarseIterations > 0;
  request.rules = {plan.loss, plan.bounds, plan.beta1, plan.beta2, plan.densify};
  request.blending = field.blending;
  request.linearIntensity = field.linearIntensity;
  request.iterations = plan.iterations;
  request.gaussians = std::max(gaussians, field.size());
  if (plan.densify.every > 0) request.gaussians = std::max(request.gaussians, plan.densify.limit);
  request.stop = std::move(stop);
  return request;
}

Trainer::Trainer(GaussianField field, std::vector<Observation> observations, FitPlan plan,
                 const KernelSet& kernels, ThreadPool& pool)
    : plan_(std::move(plan)), request_(fitRequest(std::move(observations), plan_, field, pool.stopToken())),
      kernels_(kernels), pool_(pool), device_(std::make_unique<CpuFitDevice>(request_, kernels_, pool_)) {
  restart(std::move(field));
}

Trainer::Trainer(GaussianField field, FitRequest request, FitPlan plan, const KernelSet& kernels,
                 ThreadPool& pool, std::unique_ptr<FitDevice> device)
    : plan_(std::move(plan)), request_(std::move(request)), kernels_(kernels), pool_(pool),
      device_(std::move(device)), onCpu_(!device_) {
  if (onCpu_) device_ = std::make_unique<CpuFitDevice>(request_, kernels_, pool_);
  restart(std::move(field));
}

Trainer::~Trainer() = default;

void Trainer::restart(GaussianField field) {
  if (uploaded_ && device_->resident()) device_->take({}); // frees its memory
  state_.field = std::move(field);
  state_.adam = Adam(state_.field.size());
  state_.adam.beta1 = plan_.beta1;
  state_.adam.beta2 = plan_.beta2;
  state_.accumulator = {};
  uploaded_ = false;
  history_.clear();
  recent_.clear();
  plateau_ = {};
  densified_ = {};
  iteration_ = 0;
  mark();
}

LossSum Trainer::evaluate(const GaussianField& field) {
  LossSum sum;
  const auto work = [&] { sum = device_->evaluate(field); };
  if (!guarded(work)) work();
  return sum;
}

void Trainer::restore(OptimizerState state, int iteration) {
  state_.adam.moment1 = std::move(state.moment1);
  state_.adam.moment2 = std::move(state.moment2);
  for (float loss : state.losses)
    record(loss);
  iteration_ = iteration;
  state_.accumulator.sum = std::move(state.gradients);
  if (densifying()) {
    const int last = iteration - iteration % plan_.densify.every;
    state_.accumulator.iterations = std::max(0, iteration - std::max(plan_.coarseIterations, last));
  }
  mark();
}

/// Marks state_ as the state of the fit.
void Trainer::mark() {
  gaussians_ = state_.field.size();
  fresh_ = true;
  mark_ = {iteration_, history_.size(), densified_};
}

void Trainer::upload() {
  if (uploaded_) return;
  state_.field.cutoff = plan_.cutoff;
  if (onCpu_)
    device_->take(std::move(state_));
  else
    device_->upload(state_.field, state_.adam, state_.accumulator);
  uploaded_ = true;
}

const FitState& Trainer::state() {
  if (!uploaded_) return state_;
  if (const FitState* resident = device_->resident()) return *resident;
  if (fresh_) return state_;
  try {
    FitState now;
    device_->download(&now.field, &now.adam, &now.accumulator);
    const std::size_t count = now.field.gaussians.size();
    if (count == 0 || now.adam.moment1.size() != 16 * count || now.adam.moment2.size() != 16 * count)
      throw Error(ErrorCode::Internal, "The device returned an inconsistent state.");
    state_.field.gaussians = std::move(now.field.gaussians);
    state_.adam.moment1 = std::move(now.adam.moment1);
    state_.adam.moment2 = std::move(now.adam.moment2);
    state_.accumulator = std::move(now.accumulator);
    mark();
  } catch (const std::exception& error) {
    if (failure_.empty()) failure_ = error.what();
    rollBack();
  }
  return state_;
}

/// Continues the fit from state_ on the CPU: the device has lost everything after it.
void Trainer::rollBack() {
  iteration_ = mark_.iteration;
  history_.resize(mark_.losses);
  densified_ = mark_.densified;
  gaussians_ = state_.field.size();
  plateau_ = {};
  std::vector<float> losses;
  losses.swap(history_);
  for (float loss : losses)
    record(loss);
  fresh_ = true;
  uploaded_ = false;
  onCpu_ = true;
  device_.reset();
  device_ = std::make_unique<CpuFitDevice>(request_, kernels_, pool_);
}

/// Returns false if iterations were lost.
bool Trainer::moveToCpu(const std::string& why) {
  failure_ = why;
  const int before = iteration_;
  const bool whole = !uploaded_ || fresh_;
  if (!whole) state();
  if (!onCpu_) rollBack(); // to the identical state
  return whole || iteration_ == before;
}

/// Runs work that a device other than the CPU may fail at; on failure it runs on the CPU. Returns false, with
/// the work not done, if iterations were lost.
template <class Work>
bool Trainer::guarded(const Work& work) {
  try {
    work();
    return true;
  } catch (const Error& error) {
    if (onCpu_ || error.code() == ErrorCode::Cancelled) throw;
    if (!moveToCpu(error.what())) return false;
  } catch (const std::exception& error) {
    if (onCpu_) throw;
    if (!moveToCpu(error.what())) return false;
  }
  work();
  return true;
}

void Trainer::record(float loss) {
  const bool fine = static_cast<int>(history_.size()) >= plan_.coarseIterations;
  history_.push_back(loss);
  if (fine) plateau_.add(loss, plan_.plateau);
}

double Trainer::rateShare(int iteration) const {
  if (plan_.schedule == Schedule::Plateau) return plateau_.share();
  const double progress = static_cast<double>(iteration) / std::max(1, plan_.iterations - 1);
  return std::pow(plan_.finalRate, progress);
}

bool Trainer::step(int most) {
  if (finished()) {
    state(); // repeats what a device lost
    if (finished()) return false;
  }
  if (guarded([&] { iterate(most); }) && densifies(iteration_)) densify();
  return true;
}

/// The options of the next iteration, after `iteration` completed ones.
IterationOptions Trainer::options(int iteration) const {
  IterationOptions options;
  options.coarse = iteration < plan_.coarseIterations;
  if (plan_.subsets > 1) options.subset = iteration % plan_.subsets;
  options.accumulateGradients = densifying(iteration);
  options.rates = plan_.rates * rateShare(iteration);
  options.step = iteration + 1;
  if (!options.coarse && plan_.relocateEvery > 0 && options.step % plan_.relocateEvery == 0 &&
      options.step <= plan_.relocateUntil * plan_.iterations)
    options.relocate = {plan_.relocateShare, plan_.bounds.minLogScale};
  return options;
}

void Trainer::iterate(int most) {
  upload();
  // The plateau schedule and the stop rule check every loss.
  if (plan_.schedule == Schedule::Plateau || plan_.paperStopRule) most = 1;
  std::vector<IterationOptions> iterations{options(iteration_)};
  for (int next = iteration_ + 1; next < std::min(iteration_ + most, plan_.iterations); ++next) {
    if (densifies(next) || next == plan_.coarseIterations) break; // what follows takes a different time
    iterations.push_back(options(next));
  }
  const std::vector<LossSum> sums = device_->iterateMany(iterations);
  if (sums.empty() || sums.size() > iterations.size())
    throw Error(ErrorCode::Internal, "The device did not run the requested number of iterations.");
  fresh_ = false;
  recent_.resize(static_cast<std::size_t>(plan_.subsets));
  for (const LossSum& sum : sums) {
    recent_[static_cast<std::size_t>(iteration_++ % plan_.subsets)] = sum;
    LossSum all;
    for (const LossSum& subset : recent_)
      all += subset;
    const double samples = static_cast<double>(std::max<std::int64_t>(1, all.samples));
    loss_ = all.loss / samples;
    mse_ = all.squared / samples;
    record(static_cast<float>(loss_));
  }
}

/// Whether the next iteration contributes to a densification.
bool Trainer::densifying(int iteration) const {
  const DensifyPlan& d = plan_.densify;
  return d.every > 0 && iteration >= plan_.coarseIterations &&
         iteration - iteration % d.every + d.every <= d.until * plan_.iterations;
}

/// Whether a densification follows after this many iterations.
bool Trainer::densifies(int iterations) const {
  const DensifyPlan& d = plan_.densify;
  return d.every > 0 && iterations > plan_.coarseIterations && iterations % d.every == 0 &&
         iterations <= d.until * plan_.iterations;
}

void Trainer::densify() {
  DensifyCounts counts;
  if (!guarded([&] {
        upload();
        counts = device_->densify();
        fresh_ = false;
      }))
    return;
  densified_ += counts;
  gaussians_ += counts.split + counts.cloned - counts.pruned;
}

bool Trainer::finished() const {
  if (iteration_ >= plan_.iterations) return true;
  // Paper's stop rule: the loss fell by less than 1e-4 over 100 iterations.
  return plan_.paperStopRule && history_.size() > 100 &&
         history_[history_.size() - 101] - history_.back() < 1e-4;
}

} // namespace innergs
