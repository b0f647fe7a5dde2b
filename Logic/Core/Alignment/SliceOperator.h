#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Base/Parallel.h"

#include <span>
#include <vector>

namespace innergs {

/// One slice of a stack at its current position.
struct PlacedSlice {
  std::size_t stack = 0;
  std::int64_t index = 0; // K in the stack
  int nx = 0, ny = 0;
  std::vector<float> values; // [ny][nx]; NaN: unobserved
  std::int64_t observed = 0; // pixels
  Affine3 toWorld;           // (i, j, 0) → LPS mm, before its motion
  Vec3 normal;               // unit, LPS
  ProfileQuadrature profile; // along the normal
  Affine3 pose;              // rigid, LPS mm, applied after toWorld
  double gain = 1;           // multiplies what is read from the volume
  double weight = 1;
};

/// All slices of a stack, with its poses, averaged over squares of `factor` pixels.
std::vector<PlacedSlice> placedSlices(const Stack& stack, std::size_t index, int factor,
                                      const ProfileQuadrature& profile);

/// What slices see of a volume through their profiles, trilinear on its grid, and the transpose of that.
class SliceOperator {
public:
  /// The volume's spacing must be the same along all axes.
  SliceOperator(const GridGeometry& grid, ThreadPool& pool);

  const GridGeometry& grid() const { return grid_; }

  /// [ny][nx]; NaN where the profile leaves the grid or meets NaN, and where the slice is unobserved.
  std::vector<float> project(const std::vector<float>& volume, const PlacedSlice& slice) const;

  /// Adds the transpose applied to an image per slice ([ny][nx], 0 where nothing is known). Every voxel sums
  /// in the order of the slices, whatever the number of threads.
  void addTransposed(std::span<const PlacedSlice* const> slices, std::span<const std::vector<float>> images,
                     std::vector<float>& volume) const;

  /// For registration: at pixel (i, j), what the slice sees and how that changes with a shift (per mm) and a
  /// turn (per radian, about centre), along the LPS axes. False where project() has NaN.
  struct Sample {
    double value;
    Vec3 shift, turn;
  };
  class Reader;

private:
  GridGeometry grid_;
  ThreadPool& pool_;
  Affine3 worldToIndex_;
};

/// Reads one slice's pixels at a pose.
class SliceOperator::Reader {
public:
  Reader(const SliceOperator& op, const std::vector<float>& volume, const PlacedSlice& slice,
         const Affine3& pose, const Vec3& centre);
  bool at(int i, int j, Sample& sample) const;

private:
  const float* volume_;
  std::array<std::int64_t, 3> size_;
  Mat3 direction_;
  double handedness_, spacing_;
  Vec3 base_, alongI_, alongJ_, normal_, centre_; // index
  const ProfileQuadrature& profile_;
};

} // namespace innergs
