#include "Cuda/Fit.h"

#include "Core/Base/Error.h"
#include "Core/Base/Quantities.h"
#include "Core/Base/StopToken.h"
#include "Core/Render/FieldGradient.h"
#include "Cuda/FitMemory.h"

#include <algorithm>
#include <exception>

namespace innergs::cuda {
/// Slices [first, first + count) of a view with the planes that they are seen through.
struct Fit::Slab {
  std::int64_t first, count;
  DevicePlanes planes;
  Buffer<SubPlaneView> subPlanes;
};

struct Fit::View {
  SampleGrid grid;
  std::vector<SampleGrid> points; // the grid through each point of a pixel
  ClosedFormPsf psf;
  int subset, slices, perSlice;
  std::vector<Observation::SubPlane> subPlanes;
  Buffer<float> target;
  Buffer<std::uint8_t> weight;
  std::vector<Slab> slabs;

  std::int64_t sizeOf(const Slab& slab) const {
    return slab.planes.planeSize() * slab.planes.nz * static_cast<std::int64_t>(points.size());
  }
  std::int64_t bufferSize() const { return static_cast<std::int64_t>(grid.bufferSize() * points.size()); }

  SliceView slicesOf(const Slab& slab, const GaussianField& numbers) const {
    const std::int64_t size = slab.planes.planeSize(), at = slab.first * size;
    return {slab.count,
            size,
            grid.nx,
            grid.ny,
            grid.stride(),
            perSlice,
            slab.subPlanes.data(),
            target.data() + at,
            weight.data() + at,
            numbers.blending,
            static_cast<float>(numbers.epsilon)};
  }
};

Fit::Fit(std::unique_ptr<Executor> executor, const FitRequest& request)
    : executor_(std::move(executor)), rules_(request.rules), stop_(request.stop), slabPoints_(kSlabPoints),
      passes_(*executor_), state_(*executor_), relocation_(*executor_), others_(*executor_),
      gradient_(*executor_) {
  const FitMemory needed = fitMemory(request);
  const std::int64_t free = static_cast<std::int64_t>(executor_->freeBytes());
  if (needed.least > free)
    throw Error(ErrorCode::Memory, "The fit needs at least " + bytesText(static_cast<double>(needed.least)) +
                                       " of the device's memory, but only " +
                                       bytesText(static_cast<double>(free)) +
                                       " are free: use fewer Gaussians or the CPU.");
  addViews(*request.observations, fine_);
  if (request.coarse) {
    std::vector<Observation> half;
    for (const Observation& o : *request.observations)
      half.push_back(coarsened(o));
    addViews(half, coarse_);
  }
  if (needed.most > free) { // makes a slab's share about as large as what is available
    std::int64_t largest = 1;
    for (const View& view : fine_)
      largest = std::max(largest, view.bufferSize());
    const double share =
        static_cast<double>(free - needed.least) / static_cast<double>(needed.most - needed.least);
    slabPoints_ = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(share * static_cast<double>(std::min(largest, kSlabPoints))));
  }
  cut(fine_);
  cut(coarse_);
  passes_.setLimit(24 * request.gaussians);
}

Fit::~Fit() = default;

void Fit::addViews(const std::vector<Observation>& observations, std::vector<View>& views) {
  for (const Observation& o : observations) {
    std::vector<SampleGrid> points;
    for (std::size_t p = 0; p < o.points.size(); ++p)
      points.push_back(o.gridOf(p));
    View view{o.grid,
              std::move(points),
              o.psf,
              o.subset,
              o.slices,
              o.perSlice,
              o.subPlanes,
              Buffer<float>(*executor_),
              Buffer<std::uint8_t>(*executor_),
              {}};
    view.target.upload(o.target.data(), static_cast<std::int64_t>(o.target.size()));
    view.weight.upload(o.weight.data(), static_cast<std::int64_t>(o.weight.size()));
    views.push_back(std::move(view));
  }
}

/// Cuts the views again for slabPoints_. A view whose slabs cannot be allocated keeps the old ones.
void Fit::cut(std::vector<View>& views) {
  for (View& view : views) {
    std::vector<Slab> slabs;
    const std::int64_t perSlice =
        std::max<std::int64_t>(1, static_cast<std::int64_t>(view.grid.planeSize()) * view.perSlice);
    const std::int64_t step = std::clamp<std::int64_t>(slabPoints_ / perSlice, 1, std::max(1, view.slices));
    for (std::int64_t first = 0; first < view.slices; first += step) {
      const std::int64_t count = std::min(step, view.slices - first);
      const auto from = view.subPlanes.begin() + first * view.perSlice;
      // Planes of neighbouring slabs may interleave: each slab takes its own, in ascending order.
      std::vector<int> order;
      const int planes = view.grid.planes(); // of every point
      for (auto it = from; it != from + count * view.perSlice; ++it)
        if (it->plane < planes) order.push_back(it->plane);
      std::sort(order.begin(), order.end());
      SampleGrid grid = view.grid;
      grid.z.clear();
      for (int plane : order)
        grid.z.push_back(view.grid.z[plane]);
      std::vector<SubPlaneView> local;
      for (auto it = from; it != from + count * view.perSlice; ++it)
        local.push_back(
            {static_cast<std::int32_t>(
                 it->plane / planes * order.size() +
                 (std::lower_bound(order.begin(), order.end(), it->plane % planes) - order.begin())),
             it->weight});
      Slab slab{first, count, DevicePlanes(*executor_, grid, 0, grid.planes()),
                Buffer<SubPlaneView>(*executor_)};
      slab.subPlanes.upload(local.data(), static_cast<std::int64_t>(local.size()));
      slabs.push_back(std::move(slab));
    }
    view.slabs = std::move(slabs);
  }
}

/// Halves the slabs. Returns false if they are single slices already or if even that cannot be allocated.
bool Fit::smaller() {
  std::int64_t largest = 0;
  bool several = false;
  for (const auto* views : {&fine_, &coarse_})
    for (const View& view : *views)
      for (const Slab& slab : view.slabs) {
        largest = std::max(largest, view.sizeOf(slab));
        several = several || slab.count > 1;
      }
  if (!several) return false;
  slabPoints_ = std::max<std::int64_t>(1, std::min(slabPoints_, largest) / 2);
  passes_.shrink();
  passes_.setLimit(passes_.limit() / 2 + 1024);
  try {
    cut(fine_);
    cut(coarse_);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Memory) throw;
    return false;
  }
  return true;
}

int Fit::slabs() const {
  int n = 0;
  for (const View& view : fine_)
    n += static_cast<int>(view.slabs.size());
  return n;
}

std::string Fit::remark() const {
  int fewest = 0;
  for (const View& view : fine_) {
    fewest += static_cast<int>(view.bufferSize() / kSlabPoints + 1);
  }
  if (slabs() <= 2 * fewest) return {}; // one slice more or less per slab is not worth a remark
  return "Its memory is short: the slices are processed in " + std::to_string(slabs()) + " parts.";
}

void Fit::throwIfStopped() const {
  innergs::throwIfStopped(stop_);
}

void Fit::upload(const GaussianField& field, const Adam& adam, const GradientAccumulator& accumulator) {
  const std::int64_t count = field.size();
  state_.reserve(*executor_, count);
  const auto put = [&](Buffer<float>& buffer, const std::vector<float>& from, std::int64_t size) {
    if (static_cast<std::int64_t>(from.size()) == size)
      buffer.upload(from.data(), size);
    else
      buffer.fill(0, size);
  };
  state_.count = count;
  numbers_ = field;
  numbers_.gaussians.clear();
  beta1_ = adam.beta1;
  beta2_ = adam.beta2;
  gradientSums_ = !accumulator.sum.empty();
  accumulatedIterations_ = accumulator.iterations;
  executor_->upload(state_.field(), field.gaussians.data(), count * sizeof(Gaussian));
  put(state_.moment1, adam.moment1, 16 * count);
  put(state_.moment2, adam.moment2, 16 * count);
  put(state_.gradientSums, accumulator.sum, count);
}

void Fit::download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) {
  const std::int64_t count = state_.count;
  if (field) {
    *field = numbers_;
    field->gaussians.resize(count);
    if (count > 0) executor_->download(field->gaussians.data(), state_.field(), count * sizeof(Gaussian));
  }
  if (adam) {
    adam->beta1 = beta1_;
    adam->beta2 = beta2_;
    adam->moment1.resize(16 * count);
    adam->moment2.resize(16 * count);
    state_.moment1.download(adam->moment1.data(), 16 * count);
    state_.moment2.download(adam->moment2.data(), 16 * count);
  }
  if (accumulator) {
    accumulator->iterations = accumulatedIterations_;
    accumulator->sum.resize(gradientSums_ ? count : 0);
    if (gradientSums_) state_.gradientSums.download(accumulator->sum.data(), count);
  }
}

void Fit::enqueue(std::span<View> views, const GaussianField& numbers, const Gaussian* gaussians,
                  std::int64_t count, bool backward, int iteration, int subset) {
  bool first = true;
  for (View& view : views) {
    if (subset >= 0 && view.subset != subset) continue;
    const auto points = static_cast<int>(view.points.size());
    const auto project = [&](int point) {
      throwIfStopped();
      passes_.project(gaussians, nullptr, count, projectionFrame(view.points[point]),
                      {static_cast<float>(numbers.cutoff * numbers.cutoff), numbers.blending,
                       numbers.linearIntensity, Selection::Exact, view.psf});
    };
    const auto chain = [&](int point) {
      executor_->runOver(
          Chain{gaussians, passes_.moments(), count,
                chainRules(numbers.blending, numbers.linearIntensity, view.points[point], view.psf),
                gradient_.data(), first},
          count);
      first = false;
    };
    if (points == 1) project(0);
    for (const Slab& slab : view.slabs) {
      throwIfStopped();
      for (int point = 0; point < points; ++point) {
        if (points > 1) project(point);
        passes_.forward(slab.planes, numbers.blending, point, points);
      }
      passes_.loss(view.slicesOf(slab, numbers), rules_.loss, iteration);
      for (int point = 0; backward && point < points; ++point) {
        if (points > 1) project(point);
        passes_.backward(slab.planes, numbers.blending, points == 1 && &slab != view.slabs.data(), point,
                         points > 1);
        if (points > 1) chain(point);
      }
    }
    if (backward && points == 1 && !view.slabs.empty()) chain(0);
  }
  if (backward && first) gradient_.fill(0, 16 * count); // nothing visible
}

/// Waits for what was queued since the status was cleared: the sums of the iterations, without those that had
/// no room for all pairs. Adjusts the room for the next time, also downwards, since unused room is sorted
/// too.
std::vector<LossSum> Fit::settled(int queued, bool updating) {
  std::vector<LossSum> sums;
  if (queued == 0) return sums;
  const IterationStatus status = passes_.status();
  const std::int64_t limit = passes_.limit(), pairs = status.pairs;
  if (pairs > limit || limit > 2 * pairs + 4096) passes_.setLimit(pairs + pairs / 5 + 1024);
  const int done = pairs <= limit ? queued : updating ? static_cast<int>(status.done) : 0;
  for (int k = 0; k < done; ++k)
    sums.push_back({status.sums[k].loss, status.sums[k].squared, status.sums[k].samples});
  return sums;
}

/// Queues an iteration as number `slot` of a batch. If it throws, no parameter has changed.
void Fit::queue(const IterationOptions& options, int slot) {
  std::vector<View>& views = options.coarse && !coarse_.empty() ? coarse_ : fine_;
  const AdamStep step =
      adamStep(options.rates, rules_.bounds, beta1_, beta2_, options.step, numbers_.linearIntensity);
  throwIfStopped();
  gradient_.reserve(16 * state_.count);
  if (options.relocate) relocation_.reserve(state_.count);
  enqueue(views, numbers_, state_.field(), state_.count, true, slot, options.subset);
  throwIfStopped();
  executor_->runOver(Update{gradient_.data(), state_.count, step, state_.field(), state_.moment1.data(),
                            state_.moment2.data(),
                            options.accumulateGradients ? state_.gradientSums.data() : nullptr,
                            static_cast<float>(rules_.densify.voxel / rules_.densify.coverage),
                            passes_.deviceStatus(), passes_.guard()},
                     state_.count);
  if (options.relocate) relocation_.run(state_, gradient_, *options.relocate, passes_.guard());
}

std::vector<LossSum> Fit::iterateMany(std::span<const IterationOptions> iterations) {
  std::vector<LossSum> sums;
  std::exception_ptr failure;
  while (sums.size() < iterations.size() && !failure) {
    bool full = false;
    int queued = 0;
    passes_.clearStatus();
    try {
      for (const IterationOptions& options : iterations.subspan(sums.size())) {
        if (queued == IterationStatus::kMost) break;
        queue(options, queued);
        ++queued;
      }
    } catch (const Error& error) {
      failure = std::current_exception();
      full = error.code() == ErrorCode::Memory;
    } catch (...) {
      failure = std::current_exception();
    }
    for (const LossSum& sum : settled(queued, true)) {
      if (iterations[sums.size()].accumulateGradients) {
        gradientSums_ = true;
        ++accumulatedIterations_;
      }
      sums.push_back(sum);
    }
    if (full && smaller()) failure = nullptr;
  }
  if (sums.empty()) std::rethrow_exception(failure);
  return sums;
}

LossSum Fit::iterate(const IterationOptions& options) {
  return iterateMany({&options, 1}).front();
}

/// Runs work that throws Error(Memory) before it changes anything; if it does, retries without the buffers
/// that iterations keep.
template <class Work>
void Fit::withMemory(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Memory) throw;
    passes_.shrink();
    relocation_.clear();
    gradient_.clear();
    others_.clear();
    work();
  }
}

DensifyCounts Fit::densify() {
  DensifyCounts counts;
  withMemory([&] {
    counts = cuda::densify(*executor_, state_, numbers_.blending, accumulatedIterations_, rules_.densify);
  });
  state_.gradientSums.fill(0, state_.count);
  gradientSums_ = false;
  accumulatedIterations_ = 0;
  return counts;
}

/// The loss of any field on views and, if it is not empty, its gradient.
LossSum Fit::measure(std::span<View> views, const GaussianField& field, std::span<float> gradient) {
  for (;;) {
    try {
      passes_.clearStatus();
      others_.upload(field.gaussians.data(), field.size());
      if (!gradient.empty()) gradient_.reserve(16 * field.size());
      enqueue(views, field, others_.data(), field.size(), !gradient.empty(), 0, -1);
      const std::vector<LossSum> sums = settled(1, false);
      if (sums.empty()) continue; // now there is room for all pairs
      if (!gradient.empty()) gradient_.download(gradient.data(), 16 * field.size());
      return sums.front();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Memory || !smaller()) throw;
    }
  }
}

LossSum Fit::evaluate(const GaussianField& field) {
  return measure(fine_, field, {});
}

LossSum Fit::gradient(const GaussianField& field, std::int64_t observation, std::span<float> gradient) {
  return measure({&fine_.at(static_cast<std::size_t>(observation)), 1}, field, gradient);
}

} // namespace innergs::cuda
