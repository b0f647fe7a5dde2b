#include "Core/Features/EmbeddingTraining.h"

#include "Core/Base/Error.h"
#include "Core/Features/BlockFinder.h"
#include "Core/Features/FeatureDecoder.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Features/FeatureRows.h"
#include "Core/Features/SupportBlocks.h"
#include "Core/Features/SupportLists.h"
#include "Core/Model/FieldValue.h"
#include "Core/Prediction/ParameterAdam.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kMostSamples = 65'536; // that the autoencoder learns from
constexpr int kIterations = 20;               // of the conjugate gradients
constexpr float kRidge = 1e-3f;               // relative to a voxel's weight
constexpr std::int64_t kVoxelsPerTask = 4096;

bool isBackground(const std::string& name) {
  std::string lower;
  for (const char c : name)
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower == "background";
}

/// Class 0 and one per text; throws for a text that cannot be one. Returns the first class that has a text.
int addClasses(const EmbeddingVolume& teacher, const std::vector<TextEmbedding>& texts, FeatureModel& model) {
  const std::size_t size = teacher.channels.size();
  model.names = {"background"};
  model.labels = {0};
  model.embeddings.assign(size, 0.f);
  bool background = false;
  for (const TextEmbedding& text : texts) {
    if (text.values.size() != size)
      throw Error(ErrorCode::InvalidArgument, "The text embedding of \"" + text.name + "\" has " +
                                                  std::to_string(text.values.size()) +
                                                  " numbers, the feature volume " + std::to_string(size) +
                                                  ": give the texts of the model that made the features.");
    double square = 0;
    for (const float x : text.values)
      square += static_cast<double>(x) * static_cast<double>(x);
    if (!(square > 0) || !std::isfinite(square))
      throw Error(ErrorCode::InvalidArgument,
                  "The text embedding of \"" + text.name + "\" is 0 or not finite.");
    const auto scale = static_cast<float>(1 / std::sqrt(square));
    std::vector<float> unit;
    for (const float x : text.values)
      unit.push_back(scale * x);
    if (isBackground(text.name)) {
      background = true;
      std::copy(unit.begin(), unit.end(), model.embeddings.begin());
      continue;
    }
    model.names.push_back(text.name);
    model.labels.push_back(static_cast<std::uint16_t>(model.names.size() - 1));
    model.embeddings.insert(model.embeddings.end(), unit.begin(), unit.end());
  }
  if (model.names.size() < 2)
    throw Error(ErrorCode::InvalidArgument, "There are no text embeddings: give at least one.");
  if (model.names.size() > 65535)
    throw Error(ErrorCode::InvalidArgument, "There are more than 65534 text embeddings: give fewer.");
  return background ? 0 : 1;
}

/// Unit embeddings of the teacher's voxels.
class UnitEmbeddings {
public:
  explicit UnitEmbeddings(const EmbeddingVolume& volume) : volume_(volume) {}

  int size() const { return static_cast<int>(volume_.channels.size()); }
  /// False where there is none.
  bool unit(std::int64_t voxel, float* out) const {
    double square = 0;
    for (std::size_t c = 0; c < volume_.channels.size(); ++c) {
      out[c] = volume_.channels[c][static_cast<std::size_t>(voxel)];
      square += static_cast<double>(out[c]) * static_cast<double>(out[c]);
    }
    if (!(square > 0) || !std::isfinite(square)) return false;
    const auto scale = static_cast<float>(1 / std::sqrt(square));
    for (int c = 0; c < size(); ++c)
      out[c] *= scale;
    return true;
  }

private:
  const EmbeddingVolume& volume_;
};

/// Latents F = A·f nearest to the targets of the rows, all channels side by side.
void solveLatents(const FeatureRows& rows, const std::vector<float>& targets,
                  const std::vector<std::uint8_t>& known, int channels, std::vector<float>& latents,
                  ThreadPool& pool, const std::function<void(double)>& progress) {
  const auto count = static_cast<std::int64_t>(rows.voxels.size()), gaussians = rows.columns();
  const auto n = static_cast<std::size_t>(channels);
  std::vector<float> image(static_cast<std::size_t>(count) * n);
  // image = A·values, or targets − A·values; 0 where nothing is known
  const auto forward = [&](const std::vector<float>& values, bool residual) {
    pool.blocks(count, kVoxelsPerTask, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t row = first; row < last; ++row) {
        float* out = image.data() + static_cast<std::size_t>(row) * n;
        std::fill_n(out, n, 0.f);
        if (!known[static_cast<std::size_t>(row)]) continue;
        rows.forRow(row, [&](std::uint32_t g, float weight) {
          for (std::size_t c = 0; c < n; ++c)
            out[c] += weight * values[g * n + c];
        });
        if (residual)
          for (std::size_t c = 0; c < n; ++c)
            out[c] = targets[static_cast<std::size_t>(row) * n + c] - out[c];
      }
    });
  };
  const auto transposed = [&](std::vector<float>& out) { // out = Aᵀ·image
    pool.blocks(gaussians, 256, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t g = first; g < last; ++g) {
        float* sum = out.data() + static_cast<std::size_t>(g) * n;
        std::fill_n(sum, n, 0.f);
        rows.forColumn(g, [&](std::uint32_t row, float weight) {
          for (std::size_t c = 0; c < n; ++c)
            sum[c] += weight * image[row * n + c];
        });
      }
    });
  };
  const auto dots = [&](const std::vector<float>& a, const std::vector<float>& b) {
    std::vector<double> sum(n, 0.0); // in order, whatever the threads
    for (std::size_t i = 0; i < a.size(); ++i)
      sum[i % n] += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    return sum;
  };
  std::vector<float> r(latents.size()), p, q(latents.size());
  forward(latents, true);
  transposed(r);
  for (std::size_t i = 0; i < r.size(); ++i)
    r[i] -= kRidge * latents[i];
  p = r;
  std::vector<double> rr = dots(r, r);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    forward(p, false);
    transposed(q);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] += kRidge * p[i];
    const std::vector<double> pq = dots(p, q);
    std::vector<float> step(n, 0.f), keep(n, 0.f);
    for (std::size_t c = 0; c < n; ++c)
      if (pq[c] > 0) step[c] = static_cast<float>(rr[c] / pq[c]);
    for (std::size_t i = 0; i < r.size(); ++i) {
      latents[i] += step[i % n] * p[i];
      r[i] -= step[i % n] * q[i];
    }
    const std::vector<double> next = dots(r, r);
    for (std::size_t c = 0; c < n; ++c)
      if (rr[c] > 0) keep[c] = static_cast<float>(next[c] / rr[c]);
    rr = next;
    for (std::size_t i = 0; i < p.size(); ++i)
      p[i] = r[i] + keep[i % n] * p[i];
    progress((iteration + 1.0) / kIterations);
  }
}

/// Refines latents and decoder together on the cross-entropy of the classes that the teacher means, at the
/// voxels of Gaussians that several classes share: there the nearest blend of latents need not decode to the
/// right one.
class Refinement {
public:
  Refinement(const FeatureRows& rows, const std::vector<SoftLabel>& meant,
             const std::vector<std::uint8_t>& known, const GridGeometry& grid, FeatureModel& model,
             const NetworkKernels& kernels, ThreadPool& pool)
      : rows_(rows), meant_(meant), lists_(model.support), model_(model), kernels_(kernels), pool_(pool),
        mixed_(static_cast<std::size_t>(rows.columns()), 0) {
    const auto count = static_cast<std::int64_t>(rows.voxels.size());
    pool.blocks(rows.columns(), 256, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t g = first; g < last; ++g) {
        int seen = -1;
        rows.forColumn(g, [&](std::uint32_t row, float weight) {
          if (weight < kLeastWeight || !known[row]) return;
          const int c = classOf(row);
          if (seen >= 0 && c != seen) mixed_[static_cast<std::size_t>(g)] = 1;
          seen = c;
        });
      }
    });
    const BlockFinder blockOf(model.support.blocks, grid.indexToWorld());
    const std::int64_t nx = grid.size[0], ny = grid.size[1];
    positionOf_.assign(static_cast<std::size_t>(count), -1);
    for (std::int64_t row = 0; row < count; ++row) {
      bool any = false;
      rows.forRow(row, [&](std::uint32_t g, float) { any = any || mixed_[g]; });
      if (!any || !known[static_cast<std::size_t>(row)]) continue;
      positionOf_[static_cast<std::size_t>(row)] = static_cast<std::int64_t>(active_.size());
      active_.push_back(row);
      const std::int64_t v = rows.voxels[static_cast<std::size_t>(row)];
      blocks_.push_back(blockOf({static_cast<double>(v % nx), static_cast<double>(v / nx % ny),
                                 static_cast<double>(v / (nx * ny))}));
    }
  }

  void run(const std::function<void(double)>& progress) {
    EmbeddingDecoder& decoder = *model_.decoder;
    double square = 0;
    for (const float x : model_.latents)
      square += static_cast<double>(x) * static_cast<double>(x);
    const double spread =
        std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, model_.latents.size())));
    ParameterAdam latentAdam(model_.latents.size()), decoderAdam(decoder.parameters.size());
    std::vector<float> gradient(model_.latents.size(), 0.f), decoderGradient;
    for (int iteration = 0; iteration < kRefinements && !active_.empty(); ++iteration) {
      differentiate(decoderGradient);
      gather(gradient);
      const double decay = 1 - 0.95 * iteration / kRefinements;
      latentAdam.apply(model_.latents, gradient, kLatentRate * spread * decay, kernels_);
      decoderAdam.apply(decoder.parameters, decoderGradient, kDecoderRate * decay, kernels_);
      progress((iteration + 1.0) / kRefinements);
    }
  }

private:
  static constexpr int kRefinements = 40;
  static constexpr double kLatentRate = 0.1, kDecoderRate = 1e-3; // the former relative to the latents' RMS
  static constexpr float kLeastWeight = 0.02f;
  static constexpr std::int64_t kPart = 4096, kRun = 128; // rows of a task, and at once

  int classOf(std::int64_t row) const {
    return meant_[static_cast<std::size_t>(rows_.voxels[static_cast<std::size_t>(row)])].classes[0];
  }

  /// ∂L/∂F of the active rows and ∂L/∂(decoder), both per row.
  void differentiate(std::vector<float>& decoderGradient) {
    const EmbeddingDecoder& decoder = *model_.decoder;
    const auto n = static_cast<std::size_t>(model_.channels);
    const auto count = static_cast<std::int64_t>(active_.size());
    const std::int64_t parts = (count + kPart - 1) / kPart;
    const std::array<DenseLayer, 2> layers = decoder.layers();
    const DenseLayer &up = layers[0], &last = layers[1];
    const float* parameters = decoder.parameters.data();
    const std::vector<float> upBack = up.transposed(parameters), lastBack = last.transposed(parameters);
    const int stride = decoder.stride();
    latentGradient_.resize(static_cast<std::size_t>(count) * n);
    partGradients_.assign(static_cast<std::size_t>(parts), {});
    pool_.run(parts, [&](std::int64_t part) {
      std::vector<float>& sum = partGradients_[static_cast<std::size_t>(part)];
      sum.assign(decoder.parameters.size(), 0.f);
      std::vector<float> latent(kRun * n), hidden(kRun * EmbeddingDecoder::kHidden),
          hiddenGradient(hidden.size()), embedding(static_cast<std::size_t>(kRun * stride)),
          embeddingGradient(embedding.size());
      const std::int64_t end = std::min(count, (part + 1) * kPart);
      for (std::int64_t from = part * kPart; from < end; from += kRun) {
        const std::int64_t rows = std::min(kRun, end - from);
        std::fill(latent.begin(), latent.end(), 0.f);
        for (std::int64_t r = 0; r < rows; ++r)
          rows_.forRow(active_[static_cast<std::size_t>(from + r)], [&](std::uint32_t g, float weight) {
            for (std::size_t c = 0; c < n; ++c)
              latent[static_cast<std::size_t>(r) * n + c] += weight * model_.latents[g * n + c];
          });
        up.forward(parameters, latent.data(), rows, kernels_, hidden.data());
        last.forward(parameters, hidden.data(), rows, kernels_, embedding.data());
        std::fill(embeddingGradient.begin(), embeddingGradient.end(), 0.f);
        for (std::int64_t r = 0; r < rows; ++r)
          embeddingLoss(
              model_, embedding.data() + r * stride, lists_.of(blocks_[static_cast<std::size_t>(from + r)]),
              classOf(active_[static_cast<std::size_t>(from + r)]), embeddingGradient.data() + r * stride);
        last.backward(hidden.data(), embedding.data(), rows, lastBack, kernels_, embeddingGradient.data(),
                      sum.data(), hiddenGradient.data());
        up.backward(latent.data(), hidden.data(), rows, upBack, kernels_, hiddenGradient.data(), sum.data(),
                    latentGradient_.data() + static_cast<std::size_t>(from) * n);
      }
    });
    decoderGradient.assign(decoder.parameters.size(), 0.f);
    for (const std::vector<float>& part : partGradients_)
      for (std::size_t i = 0; i < part.size(); ++i)
        decoderGradient[i] += part[i];
  }

  void gather(std::vector<float>& gradient) const {
    const auto n = static_cast<std::size_t>(model_.channels);
    pool_.blocks(rows_.columns(), 256, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t g = first; g < last; ++g) {
        if (!mixed_[static_cast<std::size_t>(g)]) continue;
        float* sum = gradient.data() + static_cast<std::size_t>(g) * n;
        std::fill_n(sum, n, 0.f);
        rows_.forColumn(g, [&](std::uint32_t row, float weight) {
          const std::int64_t at = positionOf_[row];
          if (at < 0) return;
          for (std::size_t c = 0; c < n; ++c)
            sum[c] += weight * latentGradient_[static_cast<std::size_t>(at) * n + c];
        });
      }
    });
  }

  const FeatureRows& rows_;
  const std::vector<SoftLabel>& meant_;
  SupportLists lists_;
  FeatureModel& model_;
  const NetworkKernels& kernels_;
  ThreadPool& pool_;
  std::vector<std::uint8_t> mixed_;      // per Gaussian
  std::vector<std::int64_t> active_;     // rows
  std::vector<std::int64_t> positionOf_; // among them, per row; −1: not one
  std::vector<std::int64_t> blocks_;     // per active row
  std::vector<float> latentGradient_;    // [active row][channel]
  std::vector<std::vector<float>> partGradients_;
};

} // namespace

double embeddingLoss(const FeatureModel& model, const float* e, std::span<const std::uint16_t> classes,
                     int truth, float* gradient) {
  const int size = model.decoder->size;
  double square = 0;
  for (int i = 0; i < size; ++i)
    square += static_cast<double>(e[i]) * static_cast<double>(e[i]);
  const double length = std::max(std::sqrt(square), 1e-6),
               scale = static_cast<double>(FeatureModel::kSharpness) / length;
  const auto text = [&](std::size_t n) {
    return model.embeddings.data() + static_cast<std::size_t>(classes[n]) * static_cast<std::size_t>(size);
  };
  std::vector<double> logit(classes.size());
  double greatest = -std::numeric_limits<double>::infinity(), sum = 0, loss = 0, mean = 0;
  for (std::size_t n = 0; n < classes.size(); ++n) {
    double dot = 0;
    for (int i = 0; i < size; ++i)
      dot += static_cast<double>(e[i]) * static_cast<double>(text(n)[i]);
    greatest = std::max(greatest, logit[n] = scale * dot);
  }
  for (const double l : logit)
    sum += std::exp(l - greatest);
  for (std::size_t n = 0; n < classes.size(); ++n) {
    const double log = logit[n] - greatest - std::log(sum);
    if (classes[n] == truth) loss = -log;
    const double residual = std::exp(log) - (classes[n] == truth ? 1 : 0);
    mean += residual * logit[n];
    if (std::fabs(residual) < 1e-6) continue;
    const auto share = static_cast<float>(scale * residual);
    for (int i = 0; i < size; ++i)
      gradient[i] += share * text(n)[i];
  }
  const auto share = static_cast<float>(mean / (length * length));
  for (int i = 0; i < size; ++i)
    gradient[i] -= share * e[i];
  return loss;
}

FeatureModel trainEmbeddings(const GaussianField& field, const EmbeddingVolume& volume,
                             const std::vector<TextEmbedding>& texts, const EmbeddingTraining& training) {
  checkField(field);
  checkGeometry(volume.geometry, "The feature volume");
  if (volume.channels.empty()) throw Error(ErrorCode::InvalidArgument, "The feature volume has no channels.");
  const std::int64_t voxels = volume.geometry.voxelCount();
  for (const auto& channel : volume.channels)
    if (static_cast<std::int64_t>(channel.size()) != voxels)
      throw Error(ErrorCode::InvalidArgument, "The feature volume's voxels do not match its grid.");
  if (training.channels != 16 && training.channels != 32)
    throw Error(ErrorCode::InvalidArgument, "A latent of embeddings has 16 or 32 channels.");
  ThreadPool pool(training.threads);
  pool.setStop(training.stop);
  const auto report = [&](double fraction) {
    pool.throwIfStopped();
    if (training.progress) training.progress(fraction);
  };
  FeatureModel model;
  model.channels = training.channels;
  const int firstClass = addClasses(volume, texts, model);
  const UnitEmbeddings teacher(volume);
  const int size = teacher.size();

  // Inside the field, where there is an embedding, and the class that it means there.
  const FieldValue value(field, volume.geometry.indexToWorld(), {});
  const std::int64_t nx = volume.geometry.size[0], ny = volume.geometry.size[1];
  std::vector<std::uint8_t> usable(static_cast<std::size_t>(voxels), 0);
  std::vector<SoftLabel> meant(usable.size(), SoftLabel{});
  pool.blocks(voxels, kVoxelsPerTask, [&](std::int64_t first, std::int64_t last) {
    std::vector<float> unit(static_cast<std::size_t>(size));
    for (std::int64_t v = first; v < last; ++v) {
      if (!value.has({static_cast<double>(v % nx), static_cast<double>(v / nx % ny),
                      static_cast<double>(v / (nx * ny))}) ||
          !teacher.unit(v, unit.data()))
        continue;
      usable[static_cast<std::size_t>(v)] = 1;
      SoftLabel& label = meant[static_cast<std::size_t>(v)];
      label.shares[0] = 1;
      float greatest = -2;
      for (int c = firstClass; c < model.classes(); ++c) {
        const float* text = model.embeddings.data() + static_cast<std::size_t>(c) * size;
        float cosine = 0;
        for (int n = 0; n < size; ++n)
          cosine += unit[n] * text[n];
        if (cosine <= greatest) continue;
        greatest = cosine;
        label.classes[0] = static_cast<std::uint16_t>(c);
      }
    }
  });
  const std::int64_t there = std::count(usable.begin(), usable.end(), 1);
  if (there == 0)
    throw Error(
        ErrorCode::NoData,
        "No embedding lies inside the model; give features of the same patient in the same position.");
  std::vector<float> samples;
  const std::int64_t every = (there + kMostSamples - 1) / kMostSamples;
  std::int64_t seen = 0;
  std::vector<float> unit(static_cast<std::size_t>(size));
  for (std::int64_t v = 0; v < voxels; ++v) {
    if (!usable[static_cast<std::size_t>(v)] || seen++ % every != 0) continue;
    teacher.unit(v, unit.data());
    samples.insert(samples.end(), unit.begin(), unit.end());
  }
  model.support = supportOf(volume.geometry, meant, model.classes(), pool);
  report(0.05);
  const NetworkKernels& kernels = networkKernels("");
  AutoencoderTraining plan;
  plan.channels = training.channels;
  plan.seed = training.seed;
  const FeatureAutoencoder autoencoder =
      trainAutoencoder(samples, size, plan, kernels, pool, [&](double f) { report(0.05 + 0.55 * f); });
  model.decoder = autoencoder.decoder;

  const FeatureRenderer renderer(field, sampleGridOf(volume.geometry, field.modelToWorld), pool);
  const FeatureRows rows = rowsOf(
      renderer, std::vector<std::uint8_t>(static_cast<std::size_t>(field.size()), 1), voxels, field, pool);
  report(0.65);
  const auto count = static_cast<std::int64_t>(rows.voxels.size());
  std::vector<float> targets(static_cast<std::size_t>(count * model.channels), 0.f);
  std::vector<std::uint8_t> known(static_cast<std::size_t>(count), 0);
  const int stride = model.decoder->stride();
  pool.blocks(count, 256, [&](std::int64_t first, std::int64_t last) {
    std::vector<float> embedding(static_cast<std::size_t>(stride), 0.f), hidden;
    for (std::int64_t row = first; row < last; ++row) {
      const std::int64_t v = rows.voxels[static_cast<std::size_t>(row)];
      if (!usable[static_cast<std::size_t>(v)]) continue;
      known[static_cast<std::size_t>(row)] = teacher.unit(v, embedding.data());
      autoencoder.encode(embedding.data(), 1, kernels, hidden, targets.data() + row * model.channels);
    }
  });
  report(0.75);
  model.latents.assign(static_cast<std::size_t>(field.size() * model.channels), 0.f);
  solveLatents(rows, targets, known, model.channels, model.latents, pool,
               [&](double f) { report(0.75 + 0.05 * f); });
  Refinement(rows, meant, known, volume.geometry, model, kernels, pool).run([&](double f) {
    report(0.8 + 0.2 * f);
  });

  return model;
}

} // namespace innergs
