#pragma once
#include "Core/Prediction/WinogradConvolution.h"

namespace innergs {

/// A small convolutional network on the grid of the slices: patch → channels, then `layers` times 3×3
/// channels → channels, each followed by a leaky rectifier, then 3×3 channels → one output per phase. All
/// channels are 0 outside the image.
class ConvolutionNetwork {
public:
  struct Shape {
    int phases = 4;
    int channels = 32; // a multiple of 16
    int layers = 4;
    bool operator==(const Shape&) const = default;
  };

  /// Multiply-adds of a forward pass for one sample, as WinogradConvolution does them.
  static double productsPerSample(const Shape& shape);

  /// How far samples see each other, along each axis, beyond their own patches.
  int reach() const { return shape_.layers + 1; }

  /// The position of a layer's weights among the parameters: [rows][columns], one column per output. Biases
  /// follow.
  struct Matrix {
    std::size_t at = 0;
    std::int64_t rows = 0, columns = 0;
  };
  std::vector<Matrix> matrices() const;

  /// The 3×3 layers' weights as forward() and backward() need them, at the points of WinogradConvolution.
  struct Transforms {
    std::vector<std::vector<float>> forward, backward; // of layer 1 … layers + 1
  };

  /// The memory of one pass; grows as needed and is reusable.
  struct Workspace {
    BorderedImage image;
    std::vector<std::vector<float>> activations; // per layer
    std::vector<float> outputs, gradient, previous;
    WinogradConvolution convolution;
  };

  /// Draws the weights from `seed`; the last layer starts at 0.
  ConvolutionNetwork(const Shape& shape, std::uint64_t seed);

  const Shape& shape() const { return shape_; }
  std::vector<float>& parameters() { return parameters_; } // size: a multiple of 16
  const std::vector<float>& parameters() const { return parameters_; }

  /// Computes work.outputs[sample][outputStride(phases)] for the samples of the features that are computed.
  /// The channels of the others count as 0, which shows within reach() of them.
  /// `transforms`: of the current parameters.
  void forward(const PatchFeatures& features, const Transforms& transforms, const NetworkKernels& kernels,
               Workspace& work) const;

  /// Adds the gradient of a loss to `gradient` (size of parameters()), given its derivative by the outputs of
  /// the last forward() with `work`, of all samples: same shape as the outputs, 0 at the features' borders.
  void backward(const PatchFeatures& features, const std::vector<float>& outputGradient,
                const Transforms& transforms, const NetworkKernels& kernels, Workspace& work,
                std::vector<float>& gradient) const;

  Transforms transforms() const;
  /// Updates what belongs to one of the matrices(); the first has no transforms.
  void transform(std::size_t matrix, Transforms& transforms) const;

private:
  std::size_t firstWeights() const { return 0; }
  std::size_t firstBias() const;
  std::size_t layerWeights(int layer) const; // 1…layers; layers + 1: the last layer
  std::size_t layerBias(int layer) const;
  int outputsOf(int layer) const; // channels; for the last layer outputStride

  Shape shape_;
  std::vector<float> parameters_;
};

} // namespace innergs
