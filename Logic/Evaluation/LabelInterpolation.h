#pragma once
#include "Core/Features/Labelmap.h"

namespace innergs {

/// Fills the unlabelled slices of a labelmap without using the image: copies the nearest labelled slice, the
/// lower one of two equally near. Throws Error(NoData) without a labelled slice.
Labelmap nearestLabelledSlice(const Labelmap& labels);

/// Likewise by shape-based interpolation (Raya & Udupa 1990): interpolates the signed distances to every
/// label's border linearly between the labelled slices; the label with the largest one wins.
Labelmap shapeBasedInterpolation(const Labelmap& labels);

/// Agreement of two labelmaps on one grid, over some of its slices, per label.
struct LabelAgreement {
  std::vector<std::int64_t> tested, truth, common,
      whole;                // voxels per label value; whole: truth in all slices
  double pixelAccuracy = 0; // over all voxels, including background

  double dice(std::size_t label) const;
  double iou(std::size_t label) const;
};
/// slices: per slice along K, 1 if it counts; empty: all. Throws Error(InvalidArgument) if the grids
/// differ.
LabelAgreement agreement(const Labelmap& tested, const Labelmap& truth,
                         const std::vector<std::uint8_t>& slices = {});

} // namespace innergs
