#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Features/Labelmap.h"

#include <array>
#include <functional>

namespace innergs {

/// What a voxel may be: its likeliest classes with their probabilities, descending; 0 past the last one. What
/// is missing to 1 belongs to other classes.
struct SoftLabel {
  static constexpr int kClasses = 4;
  std::array<std::uint16_t, kClasses> classes{};
  std::array<float, kClasses> shares{};
};

/// The labels of every voxel of a labelmap of classes 0 to classes − 1. Slices that nobody labelled follow
/// the image: a bilateral regression from the labelled slices on either side (Tomasi & Manduchi 1998), taken
/// as the prior of a random walker (Grady 2005) whose steps avoid edges of the image. `ranks`: the image on
/// the labelmap's lattice as an IntensityScale gives it. progress: fraction done. Throws Error(Cancelled).
std::vector<SoftLabel> completeLabels(const Labelmap& labels, int classes, std::span<const float> ranks,
                                      ThreadPool& pool, const std::function<void(double)>& progress = {});

} // namespace innergs
