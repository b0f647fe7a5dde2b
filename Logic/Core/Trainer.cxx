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

void Trainer::restore(std::vector<float> moment1, std::vector<float> moment2, int iteration) {
  adam_.moment1 = std::move(moment1);
  adam_.moment2 = std::move(moment2);
  iteration_ = iteration;
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
  const double progress = static_cast<double>(iteration_) / std::max(1, plan_.iterations - 1);
  const double rate = std::pow(plan_.finalRate, progress);
  LearningRates rates = plan_.rates;
  for (double* r :
       {&rates.mean, &rates.logScale, &rates.quaternion, &rates.logWeight, &rates.intensity, &rates.slope})
    *r *= rate;
  ++iteration_;
  adam_.apply(field_, gradient_, rates, plan_.bounds, iteration_, pool_);
  const double samples = static_cast<double>(std::max<std::int64_t>(1, total.samples));
  loss_ = total.loss / samples;
  mse_ = total.squared / samples;
  history_.push_back(loss_);
  if (plan_.relocateEvery > 0 && iteration_ % plan_.relocateEvery == 0 &&
      iteration_ <= plan_.relocateUntil * plan_.iterations && iteration_ > plan_.coarseIterations)
    relocate();
  return true;
}

bool Trainer::finished() const {
  if (iteration_ >= plan_.iterations) return true;
  // Paper's stop rule: the loss fell by less than 1e-4 over 100 iterations.
  return plan_.paperStopRule && history_.size() > 100 &&
         history_[history_.size() - 101] - history_.back() < 1e-4;
}

void Trainer::relocate() {
  relocateGaussians(field_, adam_, {plan_.relocateShare, plan_.bounds.minLogScale});
}

} // namespace innergs
