#include "Core/Fit/CpuFitDevice.h"

#include <algorithm>

namespace innergs {

CpuFitDevice::CpuFitDevice(const FitRequest& request, const KernelSet& kernels, ThreadPool& pool)
    : rules_(request.rules), kernels_(kernels), pool_(pool), observations_(request.observations) {
  std::size_t buffer = 0;
  if (request.coarse)
    for (const Observation& o : *observations_)
      halves_.push_back(coarsened(o));
  for (const Observation& o : halves_)
    coarse_.push_back(view(o));
  for (const Observation& o : *observations_) {
    buffer = std::max(buffer, o.lattice.bufferSize());
    fine_.push_back(view(o));
  }
  weights_.resize(buffer);
  numerators_.resize(buffer);
}

CpuFitDevice::~CpuFitDevice() = default;

CpuFitDevice::View CpuFitDevice::view(const Observation& o) const {
  return {&o, std::make_unique<LatticeRenderer>(o.lattice, kernels_, pool_, o.psf)};
}

void CpuFitDevice::upload(const GaussianField& field, const Adam& adam,
                          const GradientAccumulator& gradients) {
  state_ = {field, adam, gradients};
}

void CpuFitDevice::download(GaussianField* field, Adam* adam, GradientAccumulator* gradients) {
  if (field) *field = state_.field;
  if (adam) *adam = state_.adam;
  if (gradients) *gradients = state_.gradients;
}

LossSum CpuFitDevice::iterate(const IterationOptions& order) {
  gradient_.resize(16 * state_.field.gaussians.size());
  std::fill(gradient_.begin(), gradient_.end(), 0.f);
  LossSum total;
  for (View& view : order.coarse ? coarse_ : fine_) {
    view.renderer->forward(state_.field, {}, weights_.data(), numerators_.data());
    total +=
        lossPass(*view.observation, state_.field, rules_.loss, weights_.data(), numerators_.data(), pool_);
    view.renderer->backward(state_.field, weights_.data(), numerators_.data(), gradient_);
  }
  if (order.accumulateGradients) state_.gradients.add(gradient_, rules_.densify, pool_);
  state_.adam.apply(state_.field, gradient_, order.rates, rules_.bounds, order.step, pool_);
  if (order.relocate) relocateGaussians(state_.field, state_.adam, *order.relocate);
  return total;
}

DensifyCounts CpuFitDevice::densify() {
  return densifyGaussians(state_.field, state_.adam, state_.gradients, rules_.densify);
}

LossSum CpuFitDevice::evaluate(const GaussianField& field) {
  LossSum total;
  for (View& view : fine_) {
    view.renderer->forward(field, {}, weights_.data(), numerators_.data());
    total += lossPass(*view.observation, field, rules_.loss, weights_.data(), numerators_.data(), pool_);
  }
  return total;
}

} // namespace innergs
