#pragma once
#include "Core/Features/FeatureStep.h"
#include "Cuda/Block.h"

#include <cmath>

namespace innergs::cuda {

constexpr int kMostChannels = 32; // of a latent
constexpr int kTerms = DecoderTerms::kCount;
constexpr int kCodeChunk = 256; // entries that one thread sums for the gradient of a code

/// The decoded classes of every row minus their target, and the resulting gradient of F.
struct FeatureGradients {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  std::int64_t count; // rows
  int channels;
  const std::int64_t* rowStart;
  const FeatureEntry* rowEntries;
  const float *latents, *codes, *ranks;
  const std::int64_t *blocks, *listStart; // classes of a block: lists[listStart[b]], ...
  const std::uint16_t* lists;
  const std::uint16_t* targets; // four per row
  const float* shares;          // of them; 0: none
  const std::int64_t* offsets;  // per row: into `differences`
  float *features, *differences, *gradients;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t row) {
      float f[kMostChannels], gradient[kMostChannels];
      for (int n = 0; n < channels; ++n)
        f[n] = gradient[n] = 0;
      for (std::int64_t e = rowStart[row]; e < rowStart[row + 1]; ++e) {
        const float* latent = latents + static_cast<std::int64_t>(rowEntries[e].index) * channels;
        for (int n = 0; n < channels; ++n)
          f[n] += rowEntries[e].weight * latent[n];
      }
      const DecoderTerms terms(ranks[row]);
      const std::int64_t first = listStart[blocks[row]];
      const int classes = static_cast<int>(listStart[blocks[row] + 1] - first);
      float* difference = differences + offsets[row];
      float greatest = -INFINITY, sum = 0;
      for (int c = 0; c < classes; ++c) {
        const float* code = codes + static_cast<std::int64_t>(lists[first + c]) * kTerms * channels;
        float logit = 0;
        for (int t = 0; t < kTerms; ++t, code += channels) {
          float product = 0;
          for (int n = 0; n < channels; ++n)
            product += f[n] * code[n];
          logit += terms.v[t] * product;
        }
        difference[c] = logit;
        greatest = logit > greatest ? logit : greatest;
      }
      for (int c = 0; c < classes; ++c)
        sum += difference[c] = std::exp(difference[c] - greatest);
      for (int c = 0; c < classes; ++c) {
        difference[c] /= sum;
        for (int s = 0; s < 4 && shares[4 * row + s] > 0; ++s)
          if (targets[4 * row + s] == lists[first + c]) difference[c] -= shares[4 * row + s];
        const float* code = codes + static_cast<std::int64_t>(lists[first + c]) * kTerms * channels;
        for (int t = 0; t < kTerms; ++t, code += channels)
          for (int n = 0; n < channels; ++n)
            gradient[n] += terms.v[t] * difference[c] * code[n];
      }
      for (int n = 0; n < channels; ++n) {
        features[row * channels + n] = f[n];
        gradients[row * channels + n] = gradient[n];
      }
    });
  }
};

/// The gradient of the codes from the rows of one block, per class listed there (an entry), term and channel.
struct CodeGradients {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  std::int64_t entries;
  int channels;
  const std::int64_t* entryBlock;
  const std::int32_t* entryPlace; // in the block's list
  const std::int64_t *blockStart, *blockRows;
  const std::int64_t* offsets;
  const float *ranks, *features, *differences;
  float* partial; // [entry][term][channel]

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, entries * kTerms * channels, [&](std::int64_t i) {
      const int size = kTerms * channels;
      const std::int64_t entry = quotient(i, size);
      const int element = static_cast<int>(i - entry * size), term = element / channels;
      const int channel = element - term * channels;
      const std::int64_t b = entryBlock[entry];
      float sum = 0;
      for (std::int64_t r = blockStart[b]; r < blockStart[b + 1]; ++r) {
        const std::int64_t row = blockRows[r];
        sum += DecoderTerms(ranks[row]).v[term] * differences[offsets[row] + entryPlace[entry]] *
               features[row * channels + channel];
      }
      partial[i] = sum;
    });
  }
};

/// Sums of up to kCodeChunk entries of one class.
struct SumCodeChunks {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  std::int64_t chunks;
  int size;                       // terms × channels
  const std::int64_t* chunkStart; // entries are in order of their classes
  const float* partial;
  float* sums; // [chunk][size]

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, chunks * size, [&](std::int64_t i) {
      const std::int64_t chunk = quotient(i, size), element = i - chunk * size;
      float sum = 0;
      for (std::int64_t e = chunkStart[chunk]; e < chunkStart[chunk + 1]; ++e)
        sum += partial[e * size + element];
      sums[i] = sum;
    });
  }
};

/// Adam on the codes.
struct UpdateCodes {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  std::int64_t classes;
  int size;
  const std::int64_t* classStart; // chunks of a class
  const float* sums;
  FeatureStep step;
  float *codes, *moment1, *moment2;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, classes * size, [&](std::int64_t i) {
      const std::int64_t c = quotient(i, size), element = i - c * size;
      float sum = 0;
      for (std::int64_t chunk = classStart[c]; chunk < classStart[c + 1]; ++chunk)
        sum += sums[chunk * size + element];
      if (sum != 0) step.update(codes[i], moment1[i], moment2[i], sum, step.codeRate);
    });
  }
};

/// Adam on the latents of the Gaussians that reach a row.
struct UpdateLatents {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  std::int64_t count; // Gaussians
  int channels;
  const std::int64_t* columnStart;
  const FeatureEntry* columnEntries;
  const float* gradients;
  FeatureStep step;
  float *latents, *moment1, *moment2;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count * channels, [&](std::int64_t i) {
      const std::int64_t g = quotient(i, channels), channel = i - g * channels;
      if (columnStart[g] == columnStart[g + 1]) return;
      float sum = 0;
      for (std::int64_t e = columnStart[g]; e < columnStart[g + 1]; ++e)
        sum += columnEntries[e].weight *
               gradients[static_cast<std::int64_t>(columnEntries[e].index) * channels + channel];
      step.update(latents[i], moment1[i], moment2[i], sum, step.rate);
    });
  }
};

} // namespace innergs::cuda
