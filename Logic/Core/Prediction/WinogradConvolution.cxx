#include "Core/Prediction/WinogradConvolution.h"

#include <algorithm>
#include <array>

namespace innergs {
namespace {

constexpr int kTaps = 3, kPoints = ImageTiles::points, kTile = ImageTiles::width;
constexpr std::int64_t kTilesAtOnce = 350; // keeps their points in the cache

// G of F(6, 3)
constexpr std::array<std::array<float, kTaps>, kPoints> kWeights = {{{1, 0, 0},
                                                                     {-2.f / 9, -2.f / 9, -2.f / 9},
                                                                     {-2.f / 9, 2.f / 9, -2.f / 9},
                                                                     {1.f / 90, 1.f / 45, 2.f / 45},
                                                                     {1.f / 90, -1.f / 45, 2.f / 45},
                                                                     {32.f / 45, 16.f / 45, 8.f / 45},
                                                                     {32.f / 45, -16.f / 45, 8.f / 45},
                                                                     {0, 0, 1}}};

/// Some rows of an image and some tiles of each.
struct TileBlock {
  std::int64_t firstRow = 0, rows = 0, firstTile = 0, tiles = 0;
};

template <typename Run>
void forBlocks(const BorderedImage& image, std::span<const ColumnSpan> spans, const Run& run) {
  const std::int64_t tiles = (image.columns + kTile - 1) / kTile;
  const std::int64_t most = std::max<std::int64_t>(2, kTilesAtOnce / tiles);
  const std::int64_t blocks = (image.rows + most - 1) / most;
  for (std::int64_t b = 0; b < blocks; ++b) {
    const std::int64_t first = b * image.rows / blocks, last = (b + 1) * image.rows / blocks;
    TileBlock block{first, last - first, 0, tiles};
    if (!spans.empty()) {
      ColumnSpan all{static_cast<int>(image.columns), 0};
      for (std::int64_t r = first; r < last; ++r)
        if (spans[r].first < spans[r].last)
          all = {std::min(all.first, spans[r].first), std::max(all.last, spans[r].last)};
      block.firstTile = all.first / kTile;
      block.tiles = std::max<std::int64_t>(0, (all.last + kTile - 1) / kTile - block.firstTile);
    }
    run(block);
  }
}

/// The points of the block's rows and one more at each end: [point][row][tile][channel].
ImageTiles inputPoints(const BorderedImage& in, const float* image, const TileBlock& block,
                       const NetworkKernels& kernels, std::vector<float>& points) {
  const std::int64_t row = block.tiles * in.channels;
  const ImageTiles tiles{block.tiles, in.channels, (block.rows + kTaps - 1) * row};
  points.resize(static_cast<std::size_t>(kPoints * tiles.pointStep));
  for (std::int64_t r = 0; r < block.rows + kTaps - 1; ++r)
    kernels.inputToPoints(tiles,
                          image + in.row(block.firstRow - 1 + r) + block.firstTile * kTile * in.channels,
                          points.data() + r * row);
  return tiles;
}

} // namespace

void clearOutside(const BorderedImage& image, ColumnSpan span, float* row) {
  const auto clear = [&](std::int64_t first, std::int64_t last) {
    std::fill(row + first * image.channels, row + last * image.channels, 0.f);
  };
  if (span.first >= span.last) return clear(0, image.width());
  clear(0, span.first + 1);
  clear(span.last + 1, image.width());
}

std::vector<float> WinogradConvolution::transformed(const float* weights, int inputs, int outputs) {
  const std::size_t size = static_cast<std::size_t>(inputs) * outputs;
  std::vector<float> points(kPoints * kTaps * size);
  for (int p = 0; p < kPoints; ++p)
    for (int r = 0; r < kTaps; ++r) {
      const float* from = weights + r * kTaps * size;
      float* to = points.data() + (p * kTaps + r) * size;
      for (std::size_t i = 0; i < size; ++i)
        to[i] =
            kWeights[p][0] * from[i] + kWeights[p][1] * from[size + i] + kWeights[p][2] * from[2 * size + i];
    }
  return points;
}

void WinogradConvolution::convolve(const BorderedImage& in, const float* image,
                                   const std::vector<float>& transformedWeights, int outputs,
                                   std::span<const ColumnSpan> spans, const float* biases, float leak,
                                   const NetworkKernels& kernels, float* out) {
  const BorderedImage result{in.rows, in.columns, outputs};
  forBlocks(in, spans, [&](const TileBlock& block) {
    const std::int64_t row = block.tiles * outputs;
    if (row > 0) {
      const ImageTiles inTiles = inputPoints(in, image, block, kernels, input_);
      const ImageTiles outTiles{block.tiles, outputs, block.rows * row};
      output_.resize(static_cast<std::size_t>(kPoints * outTiles.pointStep));
      for (int p = 0; p < kPoints; ++p)
        kernels.multiply(
            {.rows = block.rows * block.tiles,
             .depth = in.channels,
             .columns = outputs,
             .a = input_.data() + p * inTiles.pointStep,
             .rowStep = in.channels,
             .b = transformedWeights.data() + static_cast<std::size_t>(p) * kTaps * in.channels * outputs,
             .c = output_.data() + p * outTiles.pointStep,
             .segments = kTaps,
             .segmentStep = block.tiles * in.channels,
             .add = false});
      for (std::int64_t r = 0; r < block.rows; ++r)
        kernels.outputOfPoints(outTiles, output_.data() + r * row, biases, leak,
                               out + ((block.firstRow + r) * result.width() + 1 + block.firstTile * kTile) *
                                         outputs);
    }
    for (std::int64_t r = block.firstRow; r < block.firstRow + block.rows; ++r)
      clearOutside(result, spans.empty() ? ColumnSpan{0, static_cast<int>(in.columns)} : spans[r],
                   out + r * result.width() * outputs);
  });
}

void WinogradConvolution::addWeightGradient(const BorderedImage& in, const float* image, int outputs,
                                            const float* outGradient, const NetworkKernels& kernels,
                                            float* weightGradient) {
  const BorderedImage result{in.rows, in.columns, outputs};
  const std::size_t size = static_cast<std::size_t>(in.channels) * outputs;
  weights_.assign(kPoints * kTaps * size, 0.f);
  forBlocks(in, {}, [&](const TileBlock& block) {
    const ImageTiles inTiles = inputPoints(in, image, block, kernels, input_);
    const std::int64_t row = block.tiles * outputs;
    const ImageTiles outTiles{block.tiles, outputs, block.rows * row};
    output_.resize(static_cast<std::size_t>(kPoints * outTiles.pointStep));
    for (std::int64_t r = 0; r < block.rows; ++r)
      kernels.gradientToPoints(outTiles, outGradient + result.row(block.firstRow + r) + outputs,
                               output_.data() + r * row);
    for (int p = 0; p < kPoints; ++p)
      for (int r = 0; r < kTaps; ++r)
        kernels.multiply({.rows = in.channels,
                          .depth = block.rows * block.tiles,
                          .columns = outputs,
                          .a = input_.data() + p * inTiles.pointStep + r * block.tiles * in.channels,
                          .rowStep = 1,
                          .step = in.channels,
                          .b = output_.data() + p * outTiles.pointStep,
                          .c = weights_.data() + (p * kTaps + r) * size});
  });
  for (int p = 0; p < kPoints; ++p)
    for (int r = 0; r < kTaps; ++r)
      for (int tap = 0; tap < kTaps; ++tap) {
        const float factor = kWeights[p][tap];
        if (factor == 0) continue;
        const float* from = weights_.data() + (p * kTaps + r) * size;
        float* to = weightGradient + (r * kTaps + tap) * size;
        for (std::size_t i = 0; i < size; ++i)
          to[i] += factor * from[i];
      }
}

} // namespace innergs
