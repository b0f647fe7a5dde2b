#pragma once
#include "Core/Acquisition/SampleGrid.h"
#include "Core/Fit/Loss.h"
#include "Core/Model/GaussianField.h"
#include "Cuda/Buffer.h"

namespace innergs::cuda {

/// Parallel planes on the device.
struct DevicePlanes {
  DevicePlanes(Executor& executor, const SampleGrid& grid, int firstPlane, int planes);
  GridView view() const { return {nx, ny, nz, stride, z.data()}; }
  std::int64_t planeSize() const { return static_cast<std::int64_t>(stride) * ny; }

  int nx, ny, nz, stride;
  Buffer<double> z;
};

/// The passes over a grid or a slab of its planes, queued one after another: nothing here waits for the
/// device, except bin() without a limit. Buffers are kept between calls.
class Passes {
public:
  explicit Passes(Executor& executor);

  Executor& executor() { return executor_; }

  /// gaussians, values (or null): device memory.
  void project(const Gaussian* gaussians, const float* values, std::int64_t count,
               const ProjectionFrame& frame, const ProjectionRules& rules);
  /// Writes W and N of the projected Gaussians (alpha: transmittance and I) to planes(): one of `points`
  /// grids of the same size, begun with point 0.
  void forward(const DevicePlanes& grid, Blending blending, int point = 0, int points = 1);
  /// Adds the loss of slices on those planes to sums number `iteration` of the status; planes() then hold F0
  /// and F1.
  void loss(const SliceView& slices, const LossKinds& kinds, int iteration = 0);
  /// Moments from F0 and F1 of a point, after forward() with the same Gaussians; `add`: to those of earlier
  /// slabs. again: project() was called since then, with the same Gaussians as for that point.
  void backward(const DevicePlanes& grid, Blending blending, bool add, int point = 0, bool again = false);
  /// I at points, three index coordinates each, with cells of 1 index unit.
  void query(const CellReach& cells, const double* points, std::int64_t count, Blending blending,
             float epsilon, float* out);

  Pair* planes() const { return planes_.data(); }
  const math::Moments<float>* moments() const { return moments_.data(); }

  /// Drops (Gaussian, bin) pairs beyond `limit`; the status has their number. Without a limit there is room
  /// for all, at the cost of waiting for their number.
  void setLimit(std::optional<std::int64_t> limit) { limit_ = limit; }
  std::int64_t limit() const { return limit_.value_or(0); }
  void clearStatus() { status_.fill(0, 1); }
  IterationStatus* deviceStatus() const { return status_.data(); }
  Guard guard() const { return {status_.data(), limit()}; }
  IterationStatus status() const; // waits

  /// Frees what depends on the size of a slab or on the number of pairs.
  void shrink();

private:
  template <class Reach>
  void bin(const Reach& reach, int shift, bool alpha);
  AlphaTile alphaTile(const TileReach& tiles) const;

  Executor& executor_;
  std::optional<std::int64_t> limit_;
  std::int64_t count_ = 0, pairs_ = 0; // Gaussians projected; room for pairs at the last bin()
  Buffer<Projected> projected_;
  Buffer<std::int64_t> counts_, first_, start_;
  Buffer<std::uint64_t> keys_, otherKeys_;
  Buffer<std::uint32_t> ids_, otherIds_, owners_;
  Buffer<math::PlaneMoments<float>> slots_;
  Buffer<math::Moments<float>> moments_;
  Buffer<Pair> planes_;
  Buffer<float> image_, r_, dMean_, dSquare_, dProduct_;
  Buffer<PartialLoss> partial_;
  Buffer<IterationStatus> status_;
};

BrickReach bricksOf(const GridView& grid);
TileReach tilesOf(const GridView& grid);

} // namespace innergs::cuda
