#include "Core/Features/FeatureTraining.h"

#include "Core/Base/Error.h"
#include "Core/Features/BlockFinder.h"
#include "Core/Features/ClassCodes.h"
#include "Core/Features/FeatureDecoder.h"
#include "Core/Features/FeatureDevices.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Features/FeatureRows.h"
#include "Core/Features/LabelCompletion.h"
#include "Core/Features/LabelResidual.h"
#include "Core/Features/SupportBlocks.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/Render.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace innergs {
namespace {

constexpr float kStartLogit = 4; // of the class that fills a Gaussian
constexpr float kPure = 0.999f;  // share from which a Gaussian holds one class
// With complete labels, longer training makes latents worse between the voxels, and the residual holds what
// they miss; unlabelled slices have no residual.
constexpr int kCompleteIterations = 10, kSparseIterations = 60;
constexpr float kCompleteRate = 0.1f, kSparseRate = 0.5f;
constexpr float kLastRate = 0.1f; // of the first one
constexpr float kCodeRate = 0.02f;
constexpr std::int64_t kCodeBlock = 8192; // rows per task that sums the gradient of the codes

/// The labelmap's values as classes, without empty ones.
Labelmap classesOf(const Labelmap& labels, const std::vector<SegmentName>& names, FeatureModel& model) {
  std::vector<std::uint8_t> used(65536, 0);
  for (std::size_t n = 0; n < labels.voxels.size(); ++n)
    used[labels.voxels[n]] = 1;
  std::map<std::uint16_t, std::string> nameOf;
  for (const SegmentName& s : names)
    if (!s.name.empty()) nameOf.emplace(s.label, s.name);
  model.names = {"background"};
  model.labels = {0};
  std::vector<std::uint16_t> classOf(65536, 0);
  for (int label = 1; label < 65536; ++label) {
    if (!used[static_cast<std::size_t>(label)]) continue;
    const auto value = static_cast<std::uint16_t>(label);
    const auto name = nameOf.find(value);
    classOf[value] = static_cast<std::uint16_t>(model.names.size());
    model.names.push_back(name == nameOf.end() ? "Segment " + std::to_string(label) : name->second);
    model.labels.push_back(value);
  }
  Labelmap classes{labels.geometry, {}, labels.labelled};
  classes.voxels.reserve(labels.voxels.size());
  for (const std::uint16_t label : labels.voxels)
    classes.voxels.push_back(classOf[label]);
  return classes;
}

bool anyLabelInside(const GaussianField& field, const Labelmap& labels) {
  const FieldValue value(field, labels.geometry.indexToWorld(), {});
  std::size_t at = 0;
  for (std::int64_t k = 0; k < labels.geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < labels.geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < labels.geometry.size[0]; ++i, ++at)
        if (labels.voxels[at] != 0 &&
            value.has({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}))
          return true;
  return false;
}

class Trainer {
public:
  Trainer(const GaussianField& field, const FeatureTraining& training, FeatureModel& model)
      : field_(field), training_(training), model_(model), pool_(training.threads) {
    pool_.setStop(training.stop);
  }

  void run(const Labelmap& classes) {
    RenderOptions render;
    render.threads = training_.threads;
    render.stop = training_.stop;
    ranks_ = innergs::render(field_, classes.geometry, render).voxels;
    model_.scale = intensityScaleOf(ranks_);
    pool_.blocks(static_cast<std::int64_t>(ranks_.size()), 65536, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t n = first; n < last; ++n)
        ranks_[n] = model_.scale(ranks_[n]);
    });
    report(0.05);
    soft_ =
        completeLabels(classes, model_.classes(), ranks_, pool_, [&](double f) { report(0.05 + 0.45 * f); });
    model_.support = supportOf(classes.geometry, soft_, model_.classes(), pool_);
    pool_.throwIfStopped();
    model_.codes = spreadCodes(model_.support, model_.classes(), model_.channels, training_.seed);
    pool_.throwIfStopped();
    const FeatureRenderer renderer(field_, sampleGridOf(classes.geometry, field_.modelToWorld), pool_);
    const bool complete = std::count(classes.labelled.begin(), classes.labelled.end(), 0) == 0;
    const int iterations = training_.iterations > 0 ? training_.iterations
                           : complete               ? kCompleteIterations
                                                    : kSparseIterations;
    withChannels(model_.channels, [&]<int N>() {
      start<N>(renderer);
      rows_ = rowsOf(renderer, mixed_, static_cast<std::int64_t>(soft_.size()), field_, pool_);
      listCandidates(classes.geometry);
      report(0.55);
      const auto iterate = [&](auto&& step) {
        for (int iteration = 0; iteration < iterations; ++iteration) {
          step(stepAt(iteration, iterations, complete ? kCompleteRate : kSparseRate));
          report(0.55 + 0.4 * (iteration + 1) / iterations);
        }
      };
      if (!iteratesOnDevice(iterations, iterate)) iterate([&](const FeatureStep& now) { step<N>(now); });
    });
    FeatureQueryOptions options;
    options.threads = training_.threads;
    options.stop = training_.stop;
    options.progress = [&](double f) { report(0.95 + 0.05 * f); };
    model_.residual = residualOf(field_, model_, classes, options);
  }

private:
  void report(double fraction) {
    pool_.throwIfStopped();
    if (training_.progress) training_.progress(fraction);
  }

  /// Initialises latents from the classes that each Gaussian covers, and finds Gaussians that cover several.
  template <int N>
  void start(const FeatureRenderer& renderer) {
    const std::int64_t count = field_.size();
    model_.latents.assign(static_cast<std::size_t>(count) * N, 0.f);
    mixed_.assign(static_cast<std::size_t>(count), 0);
    pool_.blocks(count, 64, [&](std::int64_t first, std::int64_t last) {
      std::map<std::uint16_t, float> shares;
      for (std::int64_t g = first; g < last; ++g) {
        shares.clear();
        float total = 0;
        renderer.forEachVoxel(g, [&](std::int64_t voxel, float p) {
          const SoftLabel& soft = soft_[static_cast<std::size_t>(voxel)];
          for (int s = 0; s < SoftLabel::kClasses && soft.shares[s] > 0; ++s) {
            shares[soft.classes[s]] += p * soft.shares[s];
            total += p * soft.shares[s];
          }
        });
        float greatest = 0;
        for (const auto& [c, share] : shares) {
          greatest = std::max(greatest, share);
          const float* code = model_.codeOf(c);
          for (int n = 0; n < N; ++n)
            model_.latents[static_cast<std::size_t>(g) * N + n] += kStartLogit * share / total * code[n];
        }
        mixed_[static_cast<std::size_t>(g)] = total > 0 && greatest < kPure * total;
      }
    });
  }

  void listCandidates(const GridGeometry& geometry) {
    lists_.emplace(model_.support);
    const BlockFinder blockOf(model_.support.blocks, geometry.indexToWorld());
    const std::int64_t nx = geometry.size[0], ny = geometry.size[1];
    blocks_.resize(rows_.voxels.size());
    for (std::size_t row = 0; row < blocks_.size(); ++row) {
      const std::int64_t v = rows_.voxels[row];
      blocks_[row] = blockOf({static_cast<double>(v % nx), static_cast<double>(v / nx % ny),
                              static_cast<double>(v / (nx * ny))});
    }
  }

  static FeatureStep stepAt(int iteration, int iterations, float rate) {
    const float fraction = static_cast<float>(iteration) / static_cast<float>(iterations);
    const float decay = 1 - fraction * (1 - kLastRate);
    return {rate * decay, kCodeRate * decay,
            1 - std::pow(FeatureStep::kMomentum, static_cast<float>(iteration + 1)),
            1 - std::pow(FeatureStep::kScaling, static_cast<float>(iteration + 1))};
  }

  /// False where there is no device or it failed: nothing has changed then.
  template <class Iterate>
  bool iteratesOnDevice(int iterations, Iterate&& iterate) {
    if (!training_.devices) return false;
    FeatureProblem problem{model_.channels, model_.latents, model_.codes, &rows_, &*lists_, {}, {}, blocks_};
    for (const std::int64_t voxel : rows_.voxels) {
      problem.ranks.push_back(ranks_[static_cast<std::size_t>(voxel)]);
      problem.labels.push_back(soft_[static_cast<std::size_t>(voxel)]);
    }
    try {
      const std::unique_ptr<FeatureDevice> device =
          training_.devices->make(problem, iterations, training_.stop);
      if (!device) return false;
      iterate([&](const FeatureStep& now) { device->step(now); });
      std::vector<float> latents(model_.latents.size()), codes(model_.codes.size());
      device->download(latents, codes);
      model_.latents = std::move(latents);
      model_.codes = std::move(codes);
      return true;
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Cancelled) throw;
      training_.devices->failed(error.what());
      return false;
    }
  }

  template <int N>
  void step(const FeatureStep& now) {
    const auto count = static_cast<std::int64_t>(rows_.voxels.size());
    const std::size_t codes = model_.codes.size();
    const std::int64_t parts = (count + kCodeBlock - 1) / kCodeBlock;
    gradient_.resize(static_cast<std::size_t>(count) * N);
    codeGradients_.assign(static_cast<std::size_t>(parts) * codes, 0.f);
    pool_.run(parts, [&](std::int64_t part) {
      std::vector<float> residual(lists_->longest());
      for (std::int64_t row = part * kCodeBlock; row < std::min(count, (part + 1) * kCodeBlock); ++row) {
        float latent[N] = {};
        rows_.forRow(row, [&](std::uint32_t g, float weight) {
          for (int n = 0; n < N; ++n)
            latent[n] += weight * model_.latents[static_cast<std::size_t>(g) * N + n];
        });
        const std::size_t voxel = static_cast<std::size_t>(rows_.voxels[static_cast<std::size_t>(row)]);
        const auto classes = lists_->of(blocks_[static_cast<std::size_t>(row)]);
        decode<N>(model_, latent, ranks_[voxel], classes, residual.data());
        const SoftLabel& soft = soft_[voxel];
        for (int s = 0; s < SoftLabel::kClasses && soft.shares[s] > 0; ++s)
          for (std::size_t n = 0; n < classes.size(); ++n)
            if (classes[n] == soft.classes[s]) residual[n] -= soft.shares[s];
        float* into = gradient_.data() + row * N;
        std::fill_n(into, N, 0.f);
        decodeBackward<N>(model_, latent, ranks_[voxel], classes, residual.data(), into,
                          codeGradients_.data() + static_cast<std::size_t>(part) * codes);
      }
    });
    moments_.resize(2 * model_.latents.size());
    pool_.blocks(rows_.columns(), 256, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t g = first; g < last; ++g) {
        if (rows_.isEmpty(g)) continue;
        float sum[N] = {};
        rows_.forColumn(g, [&](std::uint32_t row, float weight) {
          for (int n = 0; n < N; ++n)
            sum[n] += weight * gradient_[static_cast<std::size_t>(row) * N + n];
        });
        for (int n = 0; n < N; ++n)
          adam(now, model_.latents[static_cast<std::size_t>(g) * N + n],
               moments_.data() + 2 * (static_cast<std::size_t>(g) * N + n), sum[n], now.rate);
      }
    });
    codeMoments_.resize(2 * codes);
    for (std::size_t n = 0; n < codes; ++n) {
      float sum = 0;
      for (std::int64_t part = 0; part < parts; ++part)
        sum += codeGradients_[static_cast<std::size_t>(part) * codes + n];
      if (sum != 0) adam(now, model_.codes[n], codeMoments_.data() + 2 * n, sum, now.codeRate);
    }
  }

  static void adam(const FeatureStep& now, float& x, float* moments, float gradient, float rate) {
    now.update(x, moments[0], moments[1], gradient, rate);
  }

  const GaussianField& field_;
  const FeatureTraining& training_;
  FeatureModel& model_;
  ThreadPool pool_;
  std::vector<float> ranks_;
  std::vector<SoftLabel> soft_;
  std::vector<std::uint8_t> mixed_; // per Gaussian
  FeatureRows rows_;
  std::optional<SupportLists> lists_;
  std::vector<std::int64_t> blocks_; // per row
  std::vector<float> gradient_, codeGradients_, moments_, codeMoments_;
};

} // namespace

FeatureModel trainFeatures(const GaussianField& field, const Labelmap& labels,
                           const std::vector<SegmentName>& names, const FeatureTraining& training) {
  checkField(field);
  checkGeometry(labels.geometry, "The labelmap");
  if (static_cast<std::int64_t>(labels.voxels.size()) != labels.geometry.voxelCount() ||
      (!labels.labelled.empty() &&
       static_cast<std::int64_t>(labels.labelled.size()) != labels.geometry.size[2]))
    throw Error(ErrorCode::InvalidArgument, "The labelmap's voxels or slices do not match its grid.");
  if (training.channels != 8 && training.channels != 16 && training.channels != 32)
    throw Error(ErrorCode::InvalidArgument, "A latent has 8, 16 or 32 channels.");
  if (training.iterations < 0 || training.iterations > 100000)
    throw Error(ErrorCode::InvalidArgument, "The features need at most 100000 iterations.");
  if (!anyLabelInside(field, labels))
    throw Error(ErrorCode::NoData,
                "No label lies inside the model; give labels of the same patient in the same position.");
  FeatureModel model;
  model.channels = training.channels;
  Trainer(field, training, model).run(classesOf(labels, names, model));
  return model;
}

} // namespace innergs
