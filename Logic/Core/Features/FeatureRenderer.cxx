#include "Core/Features/FeatureRenderer.h"

#include "Core/Features/FeatureDecoder.h"

#include <algorithm>

namespace innergs {

FeatureRenderer::FeatureRenderer(const GaussianField& field, SampleGrid grid, ThreadPool& pool)
    : grid_(std::move(grid)), pool_(pool), epsilon_(static_cast<float>(field.epsilon)) {
  project(field, {}, grid_, {}, pool_, projected_);
}

void FeatureRenderer::render(std::span<const float> latents, int channels, float* out,
                             std::span<const RowPart> parts) {
  const GridView grid = view();
  Tiles tiles(grid);
  tiles.bin(projected_, grid, pool_);
  const std::int64_t nx = grid.nx, ny = grid.ny;
  const auto partOf = [&](std::int64_t k, std::int64_t y) {
    return parts.empty() ? RowPart{0, grid.nx} : parts[static_cast<std::size_t>(y + ny * k)];
  };
  withChannels(channels, [&]<int N>() {
    pool_.run(tiles.count(), [&](std::int64_t t) {
      const TileRange range = tiles.range(t, grid);
      const std::int64_t rows = range.y1 - range.y0;
      std::vector<float> weights(static_cast<std::size_t>(nx * rows * (range.k1 - range.k0)), 0.f);
      const auto weightsOf = [&](std::int64_t k, std::int64_t y) {
        return weights.data() + nx * (y - range.y0 + rows * (k - range.k0));
      };
      bool any = false;
      for (std::int64_t k = range.k0; k < range.k1; ++k)
        for (std::int64_t y = range.y0; y < range.y1; ++y) {
          const RowPart part = partOf(k, y);
          any = any || part.first < part.last;
          std::fill(out + (part.first + nx * (y + ny * k)) * N, out + (part.last + nx * (y + ny * k)) * N,
                    0.f);
        }
      if (!any) return;
      for (const std::uint32_t id : tiles.members(t)) {
        const float* latent = latents.data() + static_cast<std::size_t>(id) * N;
        forEachRow(id, range, [&](int k, int y, int x0, int x1) {
          const RowPart part = partOf(k, y);
          float* sums = weightsOf(k, y);
          float* row = out + nx * (y + ny * k) * N;
          forRow(id, k, y, std::max(x0, part.first), std::min(x1, part.last), [&](int x, float p) {
            sums[x] += p;
            float* into = row + static_cast<std::int64_t>(x) * N;
            for (int c = 0; c < N; ++c)
              into[c] += p * latent[c];
          });
        });
      }
      for (std::int64_t k = range.k0; k < range.k1; ++k)
        for (std::int64_t y = range.y0; y < range.y1; ++y) {
          const RowPart part = partOf(k, y);
          const float* sums = weightsOf(k, y);
          float* row = out + nx * (y + ny * k) * N;
          for (std::int64_t x = part.first; x < part.last; ++x) {
            const float scale = 1 / (sums[x] + epsilon_);
            for (int c = 0; c < N; ++c)
              row[x * N + c] *= scale;
          }
        }
    });
  });
}

} // namespace innergs
