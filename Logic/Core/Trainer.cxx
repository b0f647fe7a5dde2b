#include "Core/Trainer.h"

#include "Core/Relocate.h"

#include <algorithm>
#include <cmath>

namespace innergs {

Trainer::Trainer(GaussianField field, std::vector<Observation> observations, FitPlan plan,
                 const KernelSet& kernels, ThreadPool& pool)
    : field_(std::move(field)), plan_(std::move(plan)), kernels_(kernels), pool_(pool), adam_(field_.size()) {
  adam_.beta1 = plan_.beta1;
  adam_.beta2 = plan_.beta2;
  std::size_t buffer = 0;
  for (Observation& o : observations) {
    buffer = std::max(buffer, o.lattice.bufferSize());
    if (plan_.coarseIterations > 0) {
      Observation half = coarsened(o);
      auto renderer = std::make_unique<LatticeRenderer>(half.lattice, kernels_, pool_, half.psf);
      coarse_.push_back({std::move(half), std::move(renderer)});
    }
    auto renderer = std::make_unique<LatticeRenderer>(o.lattice, kernels_, pool_, o.psf);
    fine_.push_back({std::move(o), std::move(renderer)});
  }
  weights_.resize(buffer);
  numerators_.resize(buffer);
  gradient_.resize(16 * field_.gaussians.size());
}

Trainer::~Trainer() = default;

void Trainer::restart(GaussianField field) {
  field_ = std::move(field);
  std::fill(adam_.moment1.begin(), adam_.moment1.end(), 0.f);
  std::fill(adam_.moment2.begin(), adam_.moment2.end(), 0.f);
  adam_.moment1.resize(16 * field_.gaussians.size(), 0.f);
  adam_.moment2.resize(16 * field_.gaussians.size(), 0.f);
  gradient_.resize(16 * field_.gaussians.size());
  history_.clear();
  plateau_ = {};
  pulls_.clear();
  densified_ = {};
  iteration_ = 0;
}

LossSum Trainer::evaluate(const GaussianField& field) {
  LossSum total;
  for (View& view : fine_) {
    view.renderer->forward(field, {}, weights_.data(), numerators_.data());
    total += lossPass(view.observation, field, plan_.loss, weights_.data(), numerators_.data(), pool_);
  }
  return total;
}

void Trainer::restore(std::vector<float> moment1, std::vector<float> moment2, int iteration,
                      std::span<const float> losses, std::vector<float> pulls) {
  adam_.moment1 = std::move(moment1);
  adam_.moment2 = std::move(moment2);
  for (float loss : losses)
    record(loss);
  iteration_ = iteration;
  pulls_.sum = std::move(pulls);
  if (densifying()) {
    const int last = iteration - iteration % plan_.densify.every;
    pulls_.sweeps = std::max(0, iteration - std::max(plan_.coarseIterations, last));
  }
}

void Trainer::record(float loss) {
  const bool fine = static_cast<int>(history_.size()) >= plan_.coarseIterations;
  history_.push_back(loss);
  if (fine) plateau_.add(loss, plan_.plateau);
}

void PlateauSchedule::add(double loss, const PlateauRule& rule) {
  if (loss < best_ * (1 - rule.threshold)) {
    best_ = loss;
    waited_ = 0;
  } else if (++waited_ >= rule.patience) {
    share_ = std::max(rule.lowest, share_ * rule.factor);
    waited_ = 0;
  }
}

double Trainer::rateShare() const {
  if (plan_.schedule == Schedule::Plateau) return plateau_.share();
  const double progress = static_cast<double>(iteration_) / std::max(1, plan_.iterations - 1);
  return std::pow(plan_.finalRate, progress);
}

std::vector<Trainer::View>& Trainer::activeViews() {
  return iteration_ < plan_.coarseIterations ? coarse_ : fine_;
}

bool Trainer::step() {
  if (finished()) return false;
  field_.cutoff = plan_.cutoff;
  std::fill(gradient_.begin(), gradient_.end(), 0.f);
  LossSum total;
  for (View& view : activeViews()) {
    view.renderer->forward(field_, {}, weights_.data(), numerators_.data());
    total += lossPass(view.observation, field_, plan_.loss, weights_.data(), numerators_.data(), pool_);
    view.renderer->backward(field_, weights_.data(), numerators_.data(), gradient_);
  }
  const double rate = rateShare();
  LearningRates rates = plan_.rates;
  for (double* r :
       {&rates.mean, &rates.logScale, &rates.quaternion, &rates.logWeight, &rates.intensity, &rates.slope})
    *r *= rate;
  if (densifying()) pulls_.add(gradient_, plan_.densify, pool_);
  ++iteration_;
  adam_.apply(field_, gradient_, rates, plan_.bounds, iteration_, pool_);
  const double samples = static_cast<double>(std::max<std::int64_t>(1, total.samples));
  loss_ = total.loss / samples;
  mse_ = total.squared / samples;
  record(static_cast<float>(loss_));
  reshape();
  return true;
}

/// Whether the next sweep is one of those that lead up to a densification.
bool Trainer::densifying() const {
  const DensifyPlan& d = plan_.densify;
  return d.every > 0 && iteration_ >= plan_.coarseIterations &&
         iteration_ - iteration_ % d.every + d.every <= d.until * plan_.iterations;
}

void Trainer::reshape() {
  if (iteration_ <= plan_.coarseIterations) return;
  if (plan_.relocateEvery > 0 && iteration_ % plan_.relocateEvery == 0 &&
      iteration_ <= plan_.relocateUntil * plan_.iterations)
    relocateGaussians(field_, adam_, {plan_.relocateShare, plan_.bounds.minLogScale});
  const DensifyPlan& d = plan_.densify;
  if (d.every <= 0 || iteration_ % d.every != 0 || iteration_ > d.until * plan_.iterations) return;
  const DensifyCounts counts = densifyGaussians(field_, adam_, pulls_, d);
  densified_.pruned += counts.pruned;
  densified_.split += counts.split;
  densified_.cloned += counts.cloned;
  gradient_.resize(16 * field_.gaussians.size());
}

bool Trainer::finished() const {
  if (iteration_ >= plan_.iterations) return true;
  // Paper's stop rule: the loss fell by less than 1e-4 over 100 iterations.
  return plan_.paperStopRule && history_.size() > 100 &&
         history_[history_.size() - 101] - history_.back() < 1e-4;
}

} // namespace innergs
