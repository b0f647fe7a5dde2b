#pragma once
#include "Core/Features/Labelmap.h"

namespace innergs {

/// What a labelmap's slices that nobody labelled get without looking at the image: the nearest labelled
/// slice, the lower one where two are as near. Throws Error(NoData) without a labelled slice.
Labelmap nearestLabelledSlice(const Labelmap& labels);

/// The same by shape-based interpolation (Raya & Udupa 1990): signed distances to every label's border in the
/// labelled slices, linear between them; the label with the greatest wins.
Labelmap shapeBasedInterpolation(const Labelmap& labels);

/// How two labelmaps on one lattice agree on some of its slices, per label.
struct LabelAgreement {
  std::vector<std::int64_t> tested, truth, common,
      whole;                // voxels per label value; whole: truth in all slices
  double pixelAccuracy = 0; // of all voxels, background included

  double dice(std::size_t label) const;
  double iou(std::size_t label) const;
};
/// slices: per slice along K 1 where it counts; empty: all. Throws Error(InvalidArgument) for other lattices.
LabelAgreement agreement(const Labelmap& tested, const Labelmap& truth,
                         const std::vector<std::uint8_t>& slices = {});

} // namespace innergs
