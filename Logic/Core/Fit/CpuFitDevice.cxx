#include "Core/Fit/CpuFitDevice.h"

#include <algorithm>
#include <iterator>

namespace innergs {
namespace {

constexpr std::size_t kManyViews = 8;

bool rendersAlike(const Observation& a, const Observation& b) {
  return a.grid.indexToModel == b.grid.indexToModel && a.grid.nx == b.grid.nx && a.grid.ny == b.grid.ny &&
         a.grid.z == b.grid.z && a.points == b.points && a.psf.active == b.psf.active &&
         std::equal(std::begin(a.psf.covariance), std::end(a.psf.covariance), b.psf.covariance);
}

} // namespace

CpuFitDevice::CpuFitDevice(const FitRequest& request, const KernelSet& kernels, ThreadPool& pool)
    : rules_(request.rules), kernels_(kernels), pool_(pool), observations_(request.observations) {
  std::size_t buffer = 0;
  if (request.coarse)
    for (const Observation& o : *observations_)
      halves_.push_back(coarsened(o));
  for (const Observation& o : halves_)
    addView(o, coarse_);
  for (const Observation& o : *observations_) {
    buffer = std::max(buffer, o.bufferSize());
    addView(o, fine_);
  }
  weights_.resize(buffer);
  numerators_.resize(buffer);
}

CpuFitDevice::~CpuFitDevice() = default;

void CpuFitDevice::addView(const Observation& o, std::vector<View>& views) {
  if (!views.empty() && rendersAlike(*views.back().observation, o)) {
    views.push_back({&o, views.back().renderers});
    return;
  }
  View view{&o, {}};
  for (std::size_t p = 0; p < o.points.size(); ++p) {
    if (p == scratch_.size()) scratch_.push_back(std::make_shared<GridRenderer::Buffers>());
    view.renderers.push_back(
        std::make_shared<GridRenderer>(o.gridOf(p), kernels_, pool_, o.psf, scratch_[p]));
  }
  views.push_back(std::move(view));
}

/// The loss of a view; adds its gradient if that is not empty.
LossSum CpuFitDevice::addLoss(View& view, const GaussianField& field, std::span<float> gradient,
                              const GaussianBlocks* blocks) {
  const std::size_t part = view.observation->grid.bufferSize();
  for (std::size_t p = 0; p < view.renderers.size(); ++p)
    view.renderers[p]->forward(field, {}, weights_.data() + p * part, numerators_.data() + p * part, blocks);
  const LossSum sum =
      lossPass(*view.observation, field, rules_.loss, weights_.data(), numerators_.data(), pool_);
  if (gradient.empty()) return sum;
  for (std::size_t p = 0; p < view.renderers.size(); ++p)
    view.renderers[p]->backward(field, weights_.data() + p * part, numerators_.data() + p * part, gradient);
  return sum;
}

/// The field's blocks, where each view is one slice of many; null where each shows most of the field.
const GaussianBlocks* CpuFitDevice::blocksOf(const GaussianField& field) {
  if (fine_.size() < kManyViews) return nullptr;
  blocks_.measure(field, pool_);
  return &blocks_;
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
  const GaussianBlocks* blocks = blocksOf(state_.field);
  for (View& view : options.coarse ? coarse_ : fine_)
    if (options.subset < 0 || view.observation->subset == options.subset)
      total += addLoss(view, state_.field, gradient_, blocks);
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
  const GaussianBlocks* blocks = blocksOf(field);
  for (View& view : fine_)
    total += addLoss(view, field, {}, blocks);
  return total;
}

LossSum CpuFitDevice::gradient(const GaussianField& field, std::int64_t observation,
                               std::span<float> gradient) {
  std::fill(gradient.begin(), gradient.end(), 0.f);
  return addLoss(fine_.at(static_cast<std::size_t>(observation)), field, gradient);
}

} // namespace innergs
