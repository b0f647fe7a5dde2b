#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace innergs {

/// C += A·B or C = A·B in single precision, for matrices inside larger arrays: A(m, s·depth + k) =
/// a[m·rowStep + s·segmentStep + k·step], B(k, n) = b[k·columns + n], C(m, n) = c[m·columns + n].
struct MatrixProduct {
  std::int64_t rows = 0, depth = 0; // of A; the depth of one segment
  std::int64_t columns = 0;         // of B and C: a multiple of 8
  const float* a = nullptr;
  std::int64_t rowStep = 0, step = 1;
  const float* b = nullptr;
  float* c = nullptr;
  std::int64_t segments = 1, segmentStep = 0;
  bool add = true;
};

/// Columns of an image [column][channel], in tiles of 6, at the 8 points of Winograd's convolution F(6, 3).
struct ImageTiles {
  static constexpr int width = 6, points = 8;

  std::int64_t count = 0;
  int channels = 0;           // a multiple of 8
  std::int64_t pointStep = 0; // from a point [tile][channel] to the next
};

/// The constants of one Adam step; `count` parameters, a multiple of 8.
struct AdamScalars {
  float rate;         // divided by the first moment's bias correction
  float beta1, beta2; // decay rates of the moments
  float scale2;       // 1 / the second moment's bias correction
};

/// The inner loops of networks, for one instruction set. Sums run over `depth` in ascending order.
struct NetworkKernels {
  std::string name;
  void (*multiply)(const MatrixProduct& product);
  /// The transforms of F(6, 3) (Lavin and Gray 2016, §4.1): Bᵀ·d of the 8 columns d from each tile's first
  /// on; Aᵀ·m, the tiles' 6 columns, plus the channels' biases, then multiplied by `leak` where below 0; and
  /// A·g of the tiles' 6 columns g.
  void (*inputToPoints)(const ImageTiles& tiles, const float* columns, float* points);
  void (*outputOfPoints)(const ImageTiles& tiles, const float* points, const float* biases, float leak,
                         float* columns);
  void (*gradientToPoints)(const ImageTiles& tiles, const float* columns, float* points);
  /// Of values [sample][channel], channels a multiple of 8: adds the biases and multiplies by `leak` where
  /// below 0; multiplies their gradient by `leak` where the result was not above 0; adds the samples' sums.
  void (*activate)(std::int64_t samples, int channels, const float* biases, float leak, float* values);
  void (*activateBack)(std::int64_t samples, int channels, const float* activated, float leak,
                       float* gradient);
  void (*addSums)(std::int64_t samples, int channels, const float* values, float* sums);
  void (*adam)(const AdamScalars& step, std::int64_t count, const float* gradient, float* moment1,
               float* moment2, float* parameters);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<NetworkKernels>& networkKernelSets();
/// Empty name: the best. Throws Error(InvalidArgument) for a name that this processor does not support.
const NetworkKernels& networkKernels(const std::string& name);

/// The plain reference.
NetworkKernels scalarNetworkKernels();

} // namespace innergs
