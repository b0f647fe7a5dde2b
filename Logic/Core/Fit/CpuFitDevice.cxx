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
  return {&o, std::make_unique<LatticeRenderer>(o.lattice, kernels_, pool_, o.psf, scratch_)};
}

void CpuFitDevice::upload(const GaussianField& field, const Adam& adam,
                          const GradientAccumulator& accumulator) {
  state_ = {field, adam, accumulator};
}

void CpuFitDevice::download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) {
  if (field) *field = state_.field;
  if (adam) *adam = state_.adam;
  if (accumulator) *accumulator = state_.accumulator;
}

LossSum CpuFitDevice::iterate(const IterationOptions& options) {
  gradient_.resize(16 * state_.field.gaussians.size());
  std::fill(gradient_.begin(), gradient_.end(), 0.f);
  LossSum total;
  for (View& view : options.coarse ? coarse_ : fine_) {
    view.renderer->forward(state_.field, {}, weights_.data(), numerators_.data());
    total +=
        lossPass(*view.observation, state_.field, rules_.loss, weights_.data(), numerators_.data(), pool_);
    view.renderer->backward(state_.field, weights_.data(), numerators_.data(), gradient_);
  }
  if (options.accumulateGradients) state_.accumulator.add(gradient_, rules_.densify, pool_);
  state_.adam.apply(state_.field, gradient_, options.rates, rules_.bounds, options.step, pool_);
  if (options.relocate) relocateGaussians(state_.field, state_.adam, *options.relocate);
  return total;
}

DensifyCounts CpuFitDevice::densify() {
  return densifyGaussians(state_.field, state_.adam, state_.accumulator, rules_.densify);
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
