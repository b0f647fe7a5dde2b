#pragma once
#include "Core/Prediction/MatrixKernels.h"
#include "Core/Prediction/PatchFeatures.h"

namespace innergs {

/// A small convolutional network on the lattice of the slices: patch → channels, then `layers` times 3×3
/// channels → channels, each followed by a rectifier, then 3×3 channels → one output per phase. Outside the
/// image all channels are 0.
class ConvolutionNetwork {
public:
  struct Shape {
    int phases = 4;
    int channels = 32; // a multiple of 16
    int layers = 4;
    bool operator==(const Shape&) const = default;
  };

  /// A layer's weights among the parameters: [rows][columns], one column per output. Biases follow.
  struct Matrix {
    std::size_t at = 0;
    std::int64_t rows = 0, columns = 0;
  };
  std::vector<Matrix> matrices() const;

  /// What one pass needs; grows as needed and may be used again.
  struct Workspace {
    std::vector<std::vector<float>> activations; // per layer, a row of border above and below
    std::vector<float> outputs, gradient, previous;
  };

  /// Weights drawn from `seed`; the last layer starts at 0.
  ConvolutionNetwork(const Shape& shape, std::uint64_t seed);

  const Shape& shape() const { return shape_; }
  std::vector<float>& parameters() { return parameters_; } // a multiple of 16
  const std::vector<float>& parameters() const { return parameters_; }

  /// work.outputs[sample][outputStride(phases)] for every sample of the features.
  void forward(const PatchFeatures& features, const MatrixKernels& kernels, Workspace& work) const;

  /// Adds to `gradient`, as long as parameters(), that of a loss whose derivative by the outputs of the last
  /// forward() with `work` is given: the same shape as the outputs, 0 at the features' borders.
  /// `transposed`: transposedWeights() of the present parameters.
  void backward(const PatchFeatures& features, const std::vector<float>& outputGradient,
                const std::vector<float>& transposed, const MatrixKernels& kernels, Workspace& work,
                std::vector<float>& gradient) const;

  /// The weights as the way back needs them.
  std::vector<float> transposedWeights() const;

private:
  std::size_t firstWeights() const { return 0; }
  std::size_t firstBias() const;
  std::size_t layerWeights(int layer) const; // 1…layers, layers + 1: the last
  std::size_t layerBias(int layer) const;
  int outputsOf(int layer) const; // channels, or outputStride of the last

  Shape shape_;
  std::vector<float> parameters_;
};

} // namespace innergs
