#include "Core/Prediction/PlaneApplication.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>

namespace innergs {
namespace {

struct Flip {
  bool rows = false, columns = false;
};

/// With two, the planes of the two axes are reflected differently, so that they share fewer errors.
std::vector<Flip> flipsOf(Reflections reflections, const SliceSampling& sampling, int axis) {
  // Reflected slices must meet existing thin samples.
  const bool rows = std::abs(2 * sampling.centre - std::round(2 * sampling.centre)) < 1e-3;
  if (reflections == Reflections::None) return {{}};
  if (!rows) return {{}, {false, true}};
  if (reflections == Reflections::Four) return {{}, {true, false}, {false, true}, {true, true}};
  if (axis == 0) return {{}, {true, true}};
  return {{true, false}, {false, true}};
}

int floorDivide(int a, int b) {
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// The memory for one plane, reused by others.
struct PlaneWork {
  std::vector<float> slices, sum, output;
  std::vector<ColumnSpan> spans;
  PatchFeatures features;
  ConvolutionNetwork::Workspace network;
};

/// Lends memory to every plane that is being computed.
class PlaneWorks {
public:
  std::unique_ptr<PlaneWork> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<PlaneWork>();
    std::unique_ptr<PlaneWork> work = std::move(free_.back());
    free_.pop_back();
    return work;
  }
  void giveBack(std::unique_ptr<PlaneWork> work) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(work));
  }

private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<PlaneWork>> free_;
};

/// The planes that contain one in-plane axis and the normal.
class Planes {
public:
  Planes(const SliceModel& model, const Volume& image, std::span<const std::uint8_t> wanted,
         const GridGeometry& thin, int axis)
      : model_(model), image_(image), wanted_(wanted), columns_(static_cast<int>(image.geometry.size[axis])),
        slices_(static_cast<int>(image.geometry.size[2])), rows_(static_cast<int>(thin.size[2])) {
    const auto& n = image.geometry.size;
    columnStep_ = axis == 0 ? 1 : n[0];
    planeStep_ = axis == 0 ? n[0] : 1;
    sliceStep_ = n[0] * n[1];
    // Slices beyond the stack whose thin samples are needed, as they are or reflected.
    const SliceSampling& s = model.sampling;
    const int mirrored = static_cast<int>(std::lround(2 * s.centre)) - s.firstPhase - s.phases + 1;
    for (const int phase : {s.firstPhase, mirrored}) {
      before_ = std::max(before_, -floorDivide(-phase, s.phases));
      after_ = std::max(after_, floorDivide(rows_ - 1 - phase, s.phases) - slices_ + 1);
    }
  }

  /// thin: the samples of the thin grid, of which it sets the plane's.
  void predict(std::int64_t plane, std::span<const Flip> flips, const NetworkKernels& kernels,
               PlaneWork& work, std::vector<float>& thin) const {
    const int phases = model_.sampling.phases;
    const int outputs = outputStride(phases);
    const int twiceCentre = static_cast<int>(std::lround(2 * model_.sampling.centre));
    auto& [slices, sum, output, spans, features, network] = work;
    slices.resize(static_cast<std::size_t>(slices_) * columns_);
    sum.assign(static_cast<std::size_t>(rows_) * columns_, 0.f);
    const std::vector<ColumnSpan> computed = spansOf(plane);
    for (const Flip flip : flips) {
      const int before = flip.rows ? after_ : before_, after = flip.rows ? before_ : after_;
      const auto sliceOf = [&](int s) { return flip.rows ? slices_ - 1 - s : s; };
      const auto columnOf = [&](int c) { return flip.columns ? columns_ - 1 - c : c; };
      for (int s = 0; s < slices_; ++s) {
        const float* in = image_.voxels.data() + sliceOf(s) * sliceStep_ + plane * planeStep_;
        float* out = slices.data() + static_cast<std::size_t>(s) * columns_;
        for (int c = 0; c < columns_; ++c)
          out[c] = in[columnOf(c) * columnStep_];
      }
      spans.clear();
      for (int s = 0; s < slices_ + before + after; ++s) {
        const ColumnSpan span = computed[std::clamp(sliceOf(s - before), 0, slices_ - 1)];
        spans.push_back(flip.columns ? ColumnSpan{columns_ - span.last, columns_ - span.first} : span);
      }
      makeFeatures(slices.data(), slices_, columns_, model_.floor, features, before, after, spans);
      predictSamples(model_, features, kernels, network, output);
      for (int s = 0; s < features.slices; ++s)
        for (int q = 0; q < phases; ++q) {
          const int phase = model_.sampling.firstPhase + q;
          const int t = sliceOf(s - before) * phases + (flip.rows ? twiceCentre - phase : phase);
          if (t < 0 || t >= rows_) continue;
          float* out = sum.data() + static_cast<std::size_t>(t) * columns_;
          const ColumnSpan span = computed[std::clamp(sliceOf(s - before), 0, slices_ - 1)];
          for (int c = span.first; c < span.last; ++c) {
            const std::int64_t at = features.at(s, columnOf(c));
            out[c] += features.mean[at] + features.deviation[at] * output[at * outputs + q];
          }
        }
    }
    const float share = 1 / static_cast<float>(flips.size());
    for (int t = 0; t < rows_; ++t) {
      float* out = thin.data() + t * sliceStep_ + plane * planeStep_;
      const float* in = sum.data() + static_cast<std::size_t>(t) * columns_;
      for (int c = 0; c < columns_; ++c)
        out[c * columnStep_] = share * in[c];
    }
  }

private:
  /// For each slice, the columns with wanted voxels, and what the network needs around them.
  std::vector<ColumnSpan> spansOf(std::int64_t plane) const {
    const int reach = model_.network ? model_.network->reach() : 0;
    std::vector<ColumnSpan> own, spans(static_cast<std::size_t>(slices_));
    for (int s = 0; s < slices_; ++s) {
      const std::uint8_t* row = wanted_.data() + s * sliceStep_ + plane * planeStep_;
      ColumnSpan span{columns_, 0};
      for (int c = 0; c < columns_; ++c)
        if (row[c * columnStep_]) span = {std::min(span.first, c), c + 1};
      own.push_back(span);
    }
    for (int s = 0; s < slices_; ++s) {
      ColumnSpan span{columns_, 0};
      for (int t = std::max(0, s - reach); t <= std::min(slices_ - 1, s + reach); ++t)
        span = {std::min(span.first, own[t].first), std::max(span.last, own[t].last)};
      if (span.first < span.last)
        spans[s] = {std::max(0, span.first - reach), std::min(columns_, span.last + reach)};
    }
    return spans;
  }

  const SliceModel& model_;
  const Volume& image_;
  std::span<const std::uint8_t> wanted_;
  int columns_, slices_, rows_, before_ = 0, after_ = 0;
  std::int64_t columnStep_ = 0, planeStep_ = 0, sliceStep_ = 0;
};

} // namespace

void predictSamples(const SliceModel& model, const PatchFeatures& features, const NetworkKernels& kernels,
                    ConvolutionNetwork::Workspace& work, std::vector<float>& output) {
  if (model.network) {
    model.network->forward(features, model.transforms, kernels, work);
    output.swap(work.outputs);
  } else {
    output.assign(static_cast<std::size_t>(features.samples()) * outputStride(model.filter.phases), 0.f);
  }
  applyFilter(model.filter, features, kernels, output.data());
}

std::array<std::vector<float>, 2> applyAcrossSlices(const SliceModel& model, const Volume& image,
                                                    std::span<const std::uint8_t> wanted,
                                                    Reflections reflections, const NetworkKernels& kernels,
                                                    const GridGeometry& thin, ThreadPool& pool,
                                                    const std::function<void(double)>& progress) {
  const auto& n = image.geometry.size;
  const double all = static_cast<double>(n[0] + n[1]);
  constexpr std::int64_t band = 16; // planes per progress report
  std::array<std::vector<float>, 2> predicted;
  PlaneWorks works;
  for (const int axis : {0, 1}) {
    const std::vector<Flip> flips = flipsOf(reflections, model.sampling, axis);
    predicted[axis].resize(static_cast<std::size_t>(thin.voxelCount()));
    const Planes planes(model, image, wanted, thin, axis);
    const std::int64_t count = n[1 - axis];
    for (std::int64_t start = 0; start < count; start += band) {
      pool.run(std::min(band, count - start), [&](std::int64_t p) {
        std::unique_ptr<PlaneWork> work = works.take();
        planes.predict(start + p, flips, kernels, *work, predicted[axis]);
        works.giveBack(std::move(work));
      });
      if (progress)
        progress(static_cast<double>((axis == 1 ? n[1] : 0) + std::min(count, start + band)) / all);
    }
  }
  return predicted;
}

} // namespace innergs
