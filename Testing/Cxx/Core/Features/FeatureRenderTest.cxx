#include "Core/Features/FeatureQuery.h"
#include "Core/Features/FeatureRenderer.h"
#include "Core/Features/FeatureRows.h"
#include "Core/Render/Render.h"
#include "RandomFields.h"

#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

GridGeometry obliqueGrid() {
  GridGeometry g;
  const double c = std::cos(0.4), s = std::sin(0.4);
  g.size = {13, 11, 9};
  g.spacing = {0.9, 1.1, 1.3};
  g.origin = {-5, -6, -4};
  g.direction = Mat3{{{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}}};
  return g;
}

FeatureModel randomLatents(const GaussianField& field, int channels) {
  Numbers random(5);
  FeatureModel features;
  features.channels = channels;
  for (std::int64_t n = 0; n < field.size() * channels; ++n)
    features.latents.push_back(static_cast<float>(random(-1, 1)));
  return features;
}

// Each channel of a latent is rendered like any scalar carried by the field's Gaussians.
TEST(FeatureRender, EqualsTheFieldsScalars) {
  const GaussianField field = randomField(200, {}, 3, Blending::Normalised, true);
  for (const int channels : {8, 16, 32}) {
    const FeatureModel features = randomLatents(field, channels);
    const std::vector<float> rendered = renderFeatures(field, features, obliqueGrid());
    for (int c = 0; c < channels; ++c) {
      std::vector<float> values;
      for (std::int64_t n = 0; n < field.size(); ++n)
        values.push_back(features.latents[static_cast<std::size_t>(n * channels + c)]);
      RenderOptions options;
      options.values = values;
      const Volume scalar = render(field, obliqueGrid(), options);
      for (std::size_t v = 0; v < scalar.voxels.size(); ++v)
        ASSERT_NEAR(rendered[v * static_cast<std::size_t>(channels) + static_cast<std::size_t>(c)],
                    scalar.voxels[v], 1e-5);
    }
  }
}

TEST(FeatureRender, PartsOfRowsAreThoseOfTheWhole) {
  const GaussianField field = randomField(200, {}, 3);
  const FeatureModel features = randomLatents(field, 16);
  const GridGeometry grid = obliqueGrid();
  const std::vector<float> whole = renderFeatures(field, features, grid);
  ThreadPool pool(2);
  std::vector<RowPart> parts;
  for (int row = 0; row < 11 * 9; ++row)
    parts.push_back({row % 5, row % 7 == 0 ? row % 5 : 13 - row % 4}); // some of them empty
  std::vector<float> some(whole.size(), -7);
  FeatureRenderer(field, sampleGridOf(grid, field.modelToWorld), pool)
      .render(features.latents, 16, some.data(), parts);
  for (std::size_t row = 0; row < parts.size(); ++row)
    for (int x = parts[row].first; x < parts[row].last; ++x)
      for (std::size_t c = 0; c < 16; ++c) {
        const std::size_t at = (row * 13 + static_cast<std::size_t>(x)) * 16 + c;
        ASSERT_EQ(some[at], whole[at]);
      }
}

// The rows that training uses are the same map, and the gradient of the latents is its transpose.
TEST(FeatureRender, RowsAndColumnsAreTheSameMap) {
  const GaussianField field = randomField(150, {}, 4);
  const FeatureModel features = randomLatents(field, 8);
  const GridGeometry grid = obliqueGrid();
  const std::vector<float> rendered = renderFeatures(field, features, grid);
  ThreadPool pool(2);
  const FeatureRenderer renderer(field, sampleGridOf(grid, field.modelToWorld), pool);
  const FeatureRows rows =
      rowsOf(renderer, std::vector<std::uint8_t>(150, 1), grid.voxelCount(), field, pool);
  ASSERT_GT(rows.voxels.size(), 500u);
  double forward = 0, backward = 0;
  for (std::size_t row = 0; row < rows.voxels.size(); ++row)
    for (int c = 0; c < 8; ++c) {
      double sum = 0;
      rows.forRow(static_cast<std::int64_t>(row), [&](std::uint32_t g, float w) {
        sum += static_cast<double>(w) *
               static_cast<double>(features.latents[g * 8 + static_cast<std::size_t>(c)]);
      });
      ASSERT_NEAR(sum, rendered[static_cast<std::size_t>(rows.voxels[row]) * 8 + static_cast<std::size_t>(c)],
                  1e-5);
      forward += sum * static_cast<double>(row % 7);
    }
  for (std::int64_t g = 0; g < rows.columns(); ++g)
    rows.forColumn(g, [&](std::uint32_t row, float w) {
      for (int c = 0; c < 8; ++c)
        backward += static_cast<double>(w) *
                    static_cast<double>(features.latents[static_cast<std::size_t>(g * 8 + c)]) *
                    static_cast<double>(row % 7);
    });
  EXPECT_NEAR(forward, backward, 1e-4 * std::abs(forward) + 1e-3);
}

} // namespace
} // namespace innergs::testing
