#pragma once
#include "Core/Image/Stack.h"

#include <span>

namespace innergs {

/// How far slices lie from where they should, after removing one rigid transform common to all, which no
/// method can know.
struct PoseErrors {
  struct Spread {
    double median = 0, ninetieth = 0, worst = 0; // over the slices
  };
  Spread millimetres; // root mean square over the body in the slice
  Spread degrees;
  double commonMillimetres = 0, commonDegrees = 0; // of what was removed, in the middle of the first stack
  std::int64_t slices = 0;                         // that show body
};

/// truth, found: per stack and slice, rigid, LPS mm, applied after the stack's indexToWorld. body: in the
/// frame of the truth; slices with fewer than 1 % of their pixels in it are left out.
PoseErrors poseErrors(std::span<const Stack> stacks, std::span<const std::vector<Affine3>> truth,
                      std::span<const std::vector<Affine3>> found, const Mask& body);

} // namespace innergs
