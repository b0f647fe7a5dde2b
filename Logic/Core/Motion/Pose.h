#pragma once
#include "Core/Motion/DynamicField.h"

namespace innergs {

/// The grid's values at a time, six per node.
std::vector<float> nodesAt(const DynamicField& field, double time);

/// Moves the Gaussians of a dynamic field to their positions at a time, and passes gradients back. Sums over
/// the Gaussians of a node have a fixed order.
class Poser {
public:
  /// For the field's anchors and grid, which must not change while it lives.
  explicit Poser(const DynamicField& field);

  /// Writes out.gaussians; out is a copy of the canonical field. nodes: the grid's values; ownTime: time
  /// (s) of the Gaussians' own displacements, nothing omits them.
  void pose(const DynamicField& field, std::span<const float> nodes, std::optional<double> ownTime,
            GaussianField& out, ThreadPool& pool) const;

  /// From dL/d(posed Gaussians), 16 floats each in the order of struct Gaussian: adds dL/d(grid values) to
  /// `nodes` and converts `gradient` in place to that of the canonical Gaussians. dL/d(own displacement)
  /// equals that of the mean.
  void backward(const DynamicField& field, std::span<const float> nodeValues, std::span<float> gradient,
                std::span<float> nodes, ThreadPool& pool);

private:
  void listMembers();

  const MotionGrid grid_;
  std::vector<MotionGrid::Place> places_; // of the anchors
  struct Member {
    std::uint32_t gaussian;
    float weight;
  };
  std::vector<std::uint32_t> first_; // of a node's members
  std::vector<Member> members_;      // by node, then by Gaussian
  std::vector<float> nodeGradients_; // dL/d(the grid's values at each Gaussian)
};

} // namespace innergs
