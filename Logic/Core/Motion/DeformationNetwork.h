#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Linear.h"
#include "Core/Motion/TimeSpline.h"
#include "Core/Prediction/NetworkKernels.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// How Gaussians change with place and time (the paper's dynamic scenes). Each level of the encoder
/// multiplies the features of six planes over (x,y), (x,z), (y,z), (x,t), (y,t) and (z,t) (HexPlane, Cao &
/// Johnson 2023), interpolated linearly in space and by cubic B-splines in time. A perceptron with two hidden
/// layers of rectifiers and linear heads then gives what is added to the parameters of a Gaussian.
struct DeformationNetwork {
  static constexpr int kChannels = 16; // of a plane
  static constexpr int kWidth = 64;    // of a hidden layer
  static constexpr int kOutputs = 16;  // in the order of struct Gaussian; the last four are not used

  struct Level {
    std::array<int, 3> size{2, 2, 2}; // nodes along each axis; at least 2
    int times = 4;                    // coefficients of the splines in time; at least 4
    bool operator==(const Level&) const = default;
  };

  std::vector<Level> levels;         // 1 to 4
  Vec3 low{0, 0, 0}, high{1, 1, 1};  // box of the planes, mm, model frame; beyond it the values at its border
  double start = 0, end = 1;         // s; beyond them the values at the nearer one
  std::array<float, kOutputs> scale; // of the heads' outputs: mm, ln, quaternion, ln, intensity
  std::vector<float> parameters;     // planes of each level in the order above, then weights and biases

  std::size_t parameterCount() const;
  std::size_t planeParameters() const; // how many come first
  std::int64_t features() const { return static_cast<std::int64_t>(levels.size()) * kChannels; }
};

/// Planes near 1, so that the features are too; weights drawn from `seed`; heads 0, so that nothing changes
/// yet.
void initialise(DeformationNetwork& network, std::uint64_t seed);

/// Throws Error(FileFormat) for a network that cannot be evaluated.
void checkDeformation(const DeformationNetwork& network);

/// Adds the gradient of w_t·Σ(second differences in time)² + w_s·Σ(differences in space)² of the planes.
void addPlaneSmoothness(const DeformationNetwork& network, double timeWeight, double spaceWeight,
                        std::span<float> gradient);

/// A network at fixed points. Bit-identical at any number of threads.
class DeformationEvaluator {
public:
  /// points: three each, mm, model frame. The network's box, levels and times must stay as they are.
  DeformationEvaluator(const DeformationNetwork& network, std::span<const float> points,
                       const NetworkKernels& kernels);

  /// The changes at a time (s): kOutputs per point.
  void forward(const DeformationNetwork& network, double time, std::span<float> out, ThreadPool& pool) const;

  /// Given the gradient of forward()'s output, kOutputs per point, adds that of the parameters.
  void backward(const DeformationNetwork& network, double time, std::span<const float> outputGradient,
                std::span<float> gradient, ThreadPool& pool);

private:
  /// Between two nodes of an axis.
  struct Place {
    std::int32_t node;
    float fraction;
  };
  struct Activations;

  void encode(const DeformationNetwork& network, std::span<const float> lines, std::int64_t first,
              std::int64_t count, float* features) const;
  void hidden(const DeformationNetwork& network, std::span<const float> lines, std::int64_t first,
              std::int64_t count, Activations& work) const;

  const NetworkKernels& kernels_;
  std::int64_t points_;
  std::vector<std::array<Place, 3>> places_;      // [level][point]
  std::vector<std::vector<float>> chunkGradient_; // of the parameters
  std::vector<std::vector<float>> chunkLineGradient_;
};

} // namespace innergs
