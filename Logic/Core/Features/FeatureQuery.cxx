#include "Core/Features/FeatureQuery.h"

#include "Core/Features/BlockFinder.h"
#include "Core/Features/ClassResidual.h"
#include "Core/Features/FeatureDecoder.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Features/SupportLists.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/Render.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace innergs {
namespace {

constexpr std::int64_t kChunk = std::int64_t{1} << 20; // voxels at once: bounds the scratch memory

/// Probabilities of classes from latents by way of embeddings.
class EmbeddingDecoding {
public:
  explicit EmbeddingDecoding(const FeatureModel& features)
      : features_(features), kernels_(networkKernels("")), columns_((features.classes() + 15) / 16 * 16),
        texts_(static_cast<std::size_t>(features.decoder->stride()) * static_cast<std::size_t>(columns_),
               0.f) {
    const int size = features.decoder->size;
    for (int c = 0; c < features.classes(); ++c)
      for (int n = 0; n < size; ++n)
        texts_[static_cast<std::size_t>(n) * columns_ + c] =
            features.embeddings[static_cast<std::size_t>(c) * size + n];
  }

  struct Work {
    std::vector<float> hidden, embeddings, products;
  };

  /// Embeddings of a row of voxels, and their products with the texts'.
  void decodeRow(const float* latents, std::int64_t voxels, Work& work) const {
    const int stride = features_.decoder->stride();
    work.embeddings.resize(static_cast<std::size_t>(voxels * stride));
    features_.decoder->decode(latents, voxels, kernels_, work.hidden, work.embeddings.data());
    work.products.assign(static_cast<std::size_t>(voxels * columns_), 0.f);
    kernels_.multiply(
        {voxels, stride, columns_, work.embeddings.data(), stride, 1, texts_.data(), work.products.data()});
  }

  void probabilities(const Work& work, std::int64_t voxel, std::span<const std::uint16_t> classes,
                     float* out) const {
    const int size = features_.decoder->size;
    const float* embedding = work.embeddings.data() + voxel * features_.decoder->stride();
    float square = 0;
    for (int n = 0; n < size; ++n)
      square += embedding[n] * embedding[n];
    const float scale = FeatureModel::kSharpness / std::max(std::sqrt(square), 1e-6f);
    float greatest = -INFINITY, sum = 0;
    for (std::size_t n = 0; n < classes.size(); ++n)
      greatest = std::max(greatest, out[n] = scale * work.products[voxel * columns_ + classes[n]]);
    for (std::size_t n = 0; n < classes.size(); ++n)
      sum += out[n] = std::exp(out[n] - greatest);
    for (std::size_t n = 0; n < classes.size(); ++n)
      out[n] /= sum;
  }

private:
  const FeatureModel& features_;
  const NetworkKernels& kernels_;
  std::int64_t columns_;
  std::vector<float> texts_; // [number][class]
};

/// Calls each(first plane, past the last plane) for chunks of a grid.
template <class Each>
void forChunks(const GridGeometry& geometry, Each&& each) {
  const std::int64_t plane = geometry.size[0] * geometry.size[1];
  const std::int64_t planes = std::clamp<std::int64_t>(kChunk / plane, 1, geometry.size[2]);
  for (std::int64_t first = 0; first < geometry.size[2]; first += planes)
    each(first, std::min(geometry.size[2], first + planes));
}

} // namespace

std::vector<float> renderFeatures(const GaussianField& field, const FeatureModel& features,
                                  const GridGeometry& geometry, const FeatureQueryOptions& options) {
  checkGeometry(geometry, "The output grid");
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const std::int64_t plane = geometry.size[0] * geometry.size[1];
  std::vector<float> latents(static_cast<std::size_t>(geometry.voxelCount() * features.channels));
  forChunks(geometry, [&](std::int64_t first, std::int64_t last) {
    FeatureRenderer(field, sampleGridOf(geometry, field.modelToWorld, first, last), pool)
        .render(features.latents, features.channels, latents.data() + first * plane * features.channels);
  });
  return latents;
}

void decodeGrid(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                const FeatureQueryOptions& options, const DecodedVisit& visit,
                const std::function<void(std::int64_t, std::int64_t)>& chunkDone) {
  checkGeometry(geometry, "The output grid");
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const FieldValue value(field, geometry.indexToWorld(), {});
  const SupportLists lists(features.support);
  const BlockFinder blockOf(features.support.blocks, geometry.indexToWorld());
  const ClassResidualSampler residual(features.residual, geometry.indexToWorld());
  std::optional<EmbeddingDecoding> embeddings;
  if (features.decoder) embeddings.emplace(features);
  RenderOptions render;
  render.threads = options.threads;
  render.stop = options.stop;
  const std::int64_t nx = geometry.size[0], ny = geometry.size[1];
  const Mat3 toIndex = inverse(geometry.indexToWorld()).linear;
  std::vector<float> displacement; // of a chunk
  /// Where the tissue at an index was when the features were learned; local: its voxel in the chunk.
  const auto learnedAt = [&](const Vec3& index, std::int64_t local) -> Vec3 {
    if (displacement.empty()) return index;
    const float* d = displacement.data() + 3 * local;
    return index + toIndex * Vec3{d[0], d[1], d[2]};
  };
  /// The block of a voxel where anything but background can be; −1: nothing to decode.
  const auto usefulBlock = [&](const Vec3& index, std::int64_t local) -> std::int64_t {
    const std::int64_t block = value.has(index) ? blockOf(learnedAt(index, local)) : -1;
    if (block < 0) return -1;
    const auto classes = lists.of(block);
    return classes.empty() || (classes.size() == 1 && classes[0] == 0) ? -1 : block;
  };
  std::vector<float> latents;
  std::vector<std::int32_t> blocks; // per voxel of a chunk
  std::vector<RowPart> parts;
  forChunks(geometry, [&](std::int64_t first, std::int64_t last) {
    const std::int64_t rows = (last - first) * ny;
    const GridGeometry own = cropped(geometry, {0, 0, first}, {nx, ny, last - first});
    if (options.displacement) displacement = options.displacement(own);
    const auto indexOf = [&](std::int64_t i, std::int64_t row) {
      return Vec3{static_cast<double>(i), static_cast<double>(row % ny),
                  static_cast<double>(first + row / ny)};
    };
    blocks.resize(static_cast<std::size_t>(rows * nx));
    parts.assign(static_cast<std::size_t>(rows), {});
    pool.run(rows, [&](std::int64_t row) {
      RowPart& part = parts[static_cast<std::size_t>(row)];
      for (std::int64_t i = 0; i < nx; ++i) {
        const std::int64_t block = usefulBlock(indexOf(i, row), row * nx + i);
        blocks[static_cast<std::size_t>(row * nx + i)] = static_cast<std::int32_t>(block);
        if (block < 0) continue;
        if (part.last == 0) part.first = static_cast<int>(i);
        part.last = static_cast<int>(i) + 1;
      }
    });
    Volume intensity; // that the classes' codes depend on
    if (!embeddings) intensity = innergs::render(field, own, render);
    latents.resize(static_cast<std::size_t>(nx * ny * (last - first) * features.channels));
    FeatureRenderer(field, sampleGridOf(geometry, field.modelToWorld, first, last), pool)
        .render(features.latents, features.channels, latents.data(), parts);
    withChannels(features.channels, [&]<int N>() {
      pool.run(rows, [&](std::int64_t row) {
        const RowPart part = parts[static_cast<std::size_t>(row)];
        if (part.first >= part.last) return;
        std::vector<float> probabilities(lists.longest());
        EmbeddingDecoding::Work work;
        if (embeddings)
          embeddings->decodeRow(latents.data() + (row * nx + part.first) * N, part.last - part.first, work);
        for (std::int64_t i = part.first; i < part.last; ++i) {
          const std::int64_t local = row * nx + i, block = blocks[static_cast<std::size_t>(local)];
          if (block < 0) continue;
          const auto classes = lists.of(block);
          if (embeddings)
            embeddings->probabilities(work, i - part.first, classes, probabilities.data());
          else
            decode<N>(features, latents.data() + local * N,
                      features.scale(intensity.voxels[static_cast<std::size_t>(local)]), classes,
                      probabilities.data());
          residual.add(learnedAt(indexOf(i, row), local), classes, probabilities.data());
          visit(local + first * nx * ny, classes, probabilities.data());
        }
      });
    });
    if (chunkDone) chunkDone(first, last);
    if (options.progress) options.progress(static_cast<double>(last) / static_cast<double>(geometry.size[2]));
  });
}

ClassImage classify(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                    const FeatureQueryOptions& options) {
  checkGeometry(geometry, "The output grid");
  ClassImage image{geometry, {}};
  image.classes.assign(static_cast<std::size_t>(geometry.voxelCount()), 0);
  decodeGrid(field, features, geometry, options,
             [&](std::int64_t voxel, std::span<const std::uint16_t> classes, const float* probabilities) {
               const auto* best = std::max_element(
                   probabilities, probabilities + static_cast<std::ptrdiff_t>(classes.size()));
               image.classes[static_cast<std::size_t>(voxel)] =
                   classes[static_cast<std::size_t>(best - probabilities)];
             });
  return image;
}

} // namespace innergs
