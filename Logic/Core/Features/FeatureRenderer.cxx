#include "Core/Features/FeatureRenderer.h"

#include "Core/Features/FeatureDecoder.h"

#include <algorithm>

namespace innergs {

FeatureRenderer::FeatureRenderer(const GaussianField& field, Lattice lattice, ThreadPool& pool)
    : lattice_(std::move(lattice)), pool_(pool), epsilon_(static_cast<float>(field.epsilon)) {
  project(field, {}, lattice_, {}, pool_, projected_);
}

void FeatureRenderer::render(std::span<const float> latents, int channels, float* out) {
  const LatticeView lattice = view();
  Tiles tiles(lattice);
  tiles.bin(projected_, lattice, pool_);
  withChannels(channels, [&]<int N>() {
    pool_.run(tiles.count(), [&](std::int64_t t) {
      const TileRange range = tiles.range(t, lattice);
      const std::int64_t rows = range.y1 - range.y0, nx = lattice.nx, ny = lattice.ny;
      std::vector<float> weights(static_cast<std::size_t>(nx * rows * (range.k1 - range.k0)), 0.f);
      const auto firstOf = [&](std::int64_t k) { return nx * (range.y0 + ny * k); };
      for (std::int64_t k = range.k0; k < range.k1; ++k)
        std::fill_n(out + firstOf(k) * N, nx * rows * N, 0.f);
      for (const std::uint32_t id : tiles.members(t)) {
        const float* latent = latents.data() + static_cast<std::size_t>(id) * N;
        visitTile(id, range, [&](std::int64_t voxel, float p) {
          const std::int64_t k = voxel / (nx * ny);
          weights[static_cast<std::size_t>(voxel - firstOf(k) + (k - range.k0) * nx * rows)] += p;
          float* into = out + voxel * N;
          for (int c = 0; c < N; ++c)
            into[c] += p * latent[c];
        });
      }
      for (std::int64_t k = range.k0; k < range.k1; ++k)
        for (std::int64_t n = 0; n < nx * rows; ++n) {
          const float scale =
              1 / (weights[static_cast<std::size_t>(n + (k - range.k0) * nx * rows)] + epsilon_);
          float* into = out + (firstOf(k) + n) * N;
          for (int c = 0; c < N; ++c)
            into[c] *= scale;
        }
    });
  });
}

} // namespace innergs
