#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <functional>

namespace innergs {

/// Thick stacks at right angles of a patient who moves, in a scanner that shades.
struct StacksCase {
  int stacks = 3;             // 1…3: axial, coronal, sagittal
  double thickness = 5;       // mm, box profile
  double gap = 0;             // mm between slices
  std::vector<double> pixels; // per stack: mm, averaged in plane; none, or 0: the volume's voxels
  bool interpolated = false;  // in plane to the volume's voxels, by cubic B-splines, as scanners may do
  double motion = 0;          // each slice is displaced by up to ± this along each axis, mm
  double turn = 0;            // and turned by up to ± this about each, degrees, around its centre; uniform
  int motionPackets = 0;      // slices k, k + this, … move together, around their centre; 0: none do
  double shading = 0;         // each stack's brightness varies smoothly by up to ± this share
  double gain = 0;            // each slice's is multiplied by 1 ± up to this
  double noise = 0;           // standard deviation, image units
  int central = 0;            // voxels of the cube that is scanned, in the middle of the volume; 0: all of it
  std::uint64_t seed = 1;
};

struct SimulatedStacks {
  Volume truth; // what is scanned: the volume or its middle
  std::vector<Stack> stacks;
  std::vector<std::function<double(const Vec3&)>> shading; // per stack: the factor where it lies, LPS mm
  std::vector<std::vector<Affine3>> poses; // where what each slice saw lay: rigid, LPS mm, as Stack::poses
};

/// The volume is interpolated by cubic B-splines at one plane per voxel of the slices' thickness. Slices that
/// move beyond the cube see what the volume holds there. Throws Error(InvalidArgument), and Error(Cancelled).
SimulatedStacks simulateStacks(const Volume& volume, const StacksCase& stacksCase, ThreadPool& pool);

} // namespace innergs
