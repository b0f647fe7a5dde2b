#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Features/Labelmap.h"

#include <array>
#include <functional>

namespace innergs {

/// A voxel's possible labels: its likeliest classes with their probabilities, in descending order; 0 after
/// the last. The remainder to 1 belongs to other classes.
struct SoftLabel {
  static constexpr int kClasses = 4;
  std::array<std::uint16_t, kClasses> classes{};
  std::array<float, kClasses> shares{};
};

/// The labels of every voxel of a labelmap of classes 0 to classes − 1. Unlabelled slices follow the image: a
/// bilateral regression from the labelled slices on either side (Tomasi & Manduchi 1998) is the prior of a
/// random walker (Grady 2005) whose steps avoid edges of the image. `ranks`: the image on the labelmap's
/// grid, mapped by an IntensityScale. progress: fraction done. Throws Error(Cancelled).
std::vector<SoftLabel> completeLabels(const Labelmap& labels, int classes, std::span<const float> ranks,
                                      ThreadPool& pool, const std::function<void(double)>& progress = {});

} // namespace innergs
