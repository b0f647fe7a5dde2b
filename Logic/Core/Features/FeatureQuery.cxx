#include "Core/Features/FeatureQuery.h"

#include "Core/Features/FeatureDecoder.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/Render.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr std::int64_t kChunk = std::int64_t{1} << 20; // voxels at once: bounds the scratch memory

Lattice planesOf(const GaussianField& field, const GridGeometry& geometry, std::int64_t first,
                 std::int64_t last) {
  Lattice lattice;
  lattice.indexToModel = inverse(field.modelToWorld) * geometry.indexToWorld();
  lattice.nx = static_cast<int>(geometry.size[0]);
  lattice.ny = static_cast<int>(geometry.size[1]);
  for (std::int64_t k = first; k < last; ++k)
    lattice.z.push_back(static_cast<double>(k));
  return lattice;
}

/// Calls each(first plane, past the last plane) for chunks of a lattice.
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
    FeatureRenderer(field, planesOf(field, geometry, first, last), pool)
        .render(features.latents, features.channels, latents.data() + first * plane * features.channels);
  });
  return latents;
}

void decodeLattice(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                   const FeatureQueryOptions& options, const DecodedVisit& visit,
                   const std::function<void(std::int64_t, std::int64_t)>& chunkDone) {
  checkGeometry(geometry, "The output grid");
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const FieldValue value(field, geometry.indexToWorld(), {});
  const SupportLists lists(features.support);
  const BlockFinder blockOf(features.support.blocks, geometry.indexToWorld());
  RenderOptions render;
  render.threads = options.threads;
  render.stop = options.stop;
  const std::int64_t nx = geometry.size[0], ny = geometry.size[1];
  std::vector<float> latents;
  forChunks(geometry, [&](std::int64_t first, std::int64_t last) {
    const Volume intensity =
        innergs::render(field, cropped(geometry, {0, 0, first}, {nx, ny, last - first}), render);
    latents.resize(static_cast<std::size_t>(nx * ny * (last - first) * features.channels));
    FeatureRenderer(field, planesOf(field, geometry, first, last), pool)
        .render(features.latents, features.channels, latents.data());
    withChannels(features.channels, [&]<int N>() {
      pool.run((last - first) * ny, [&](std::int64_t row) {
        std::vector<float> probabilities(lists.longest());
        for (std::int64_t i = 0; i < nx; ++i) {
          const std::int64_t local = row * nx + i;
          const Vec3 index{static_cast<double>(i), static_cast<double>(row % ny),
                           static_cast<double>(first + row / ny)};
          const std::int64_t block = value.has(index) ? blockOf(index) : -1;
          if (block < 0) continue;
          const auto classes = lists.of(block);
          if (classes.empty() || (classes.size() == 1 && classes[0] == 0)) continue;
          decode<N>(features, latents.data() + local * N,
                    features.scale(intensity.voxels[static_cast<std::size_t>(local)]), classes,
                    probabilities.data());
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
  decodeLattice(field, features, geometry, options,
                [&](std::int64_t voxel, std::span<const std::uint16_t> classes, const float* probabilities) {
                  const auto* best = std::max_element(
                      probabilities, probabilities + static_cast<std::ptrdiff_t>(classes.size()));
                  image.classes[static_cast<std::size_t>(voxel)] =
                      classes[static_cast<std::size_t>(best - probabilities)];
                });
  return image;
}

} // namespace innergs
