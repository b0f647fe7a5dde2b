#pragma once
#include "Core/Features/Teacher.h"
#include "Core/Image/Volume.h"

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

namespace innergs {

/// How an image is given to a network.
struct DenseNetworkOptions {
  double spacing = 0; // of the voxels that the network expects, mm; 0: the image's own
  std::array<std::int64_t, 3> window{0, 0, 0}; // voxels along I, J, K at once where the network leaves the
                                               // size open; 0: 96, or 512 of a slice
  double overlap = 0.5;                        // share of a window that the next one covers too, 0 to 0.9
  std::optional<ValueRange> range; // values that become 0 and 1, others are cut off there; unset: the image's
                                   // mean is subtracted, and the result divided by its standard deviation
  int threads = 0;                 // 0 = all cores; the result does not depend on it
  std::function<void(double)> progress; // fraction done
  std::stop_token stop;                 // stopped: throws Error(Cancelled)
};

/// The output of a network at every voxel of an image: an ONNX file that takes an image as 1 × 1 × K × J × I
/// or, slice by slice, 1 × 1 × J × I and gives 1 × channels × the same sizes or whole fractions of them:
/// features, logits or probabilities. Run by a sliding window; overlapping windows are averaged with the
/// weights of a Gaussian of an eighth of the window (Isensee et al. 2021, nnU-Net). Throws as OnnxNetwork
/// does, Error(InvalidArgument) for a network of another kind, Error(Geometry | Memory | Cancelled).
EmbeddingVolume applyNetwork(const std::filesystem::path& file, const Volume& image,
                             const DenseNetworkOptions& options = {});

/// The channel with the greatest value at each voxel, as a label. Throws Error(InvalidArgument) for a single
/// channel.
Labelmap likeliestChannel(const EmbeddingVolume& maps);

/// A network's output for an image, to learn features from: with names, the likeliest channel of each voxel,
/// channel 0 the background and channel n the segment of label n; otherwise its channels as features that
/// belong to the texts. Throws as applyNetwork() and likeliestChannel() do, Error(InvalidArgument) without
/// names and texts, or for a name without a channel.
Teacher networkTeacher(const std::filesystem::path& file, const Volume& image,
                       const std::vector<SegmentName>& names, const std::vector<TextEmbedding>& texts,
                       const DenseNetworkOptions& options = {});

} // namespace innergs
