#pragma once
#include "Core/Prediction/CandidateWeights.h"
#include "Core/Prediction/ConvexShares.h"
#include "Core/Prediction/SliceLines.h"

namespace innergs {

/// Sums of products of the candidates' errors.
struct CandidateErrors {
  Covariance<kCandidates> sum{};
  std::int64_t samples = 0;

  void add(const CandidateErrors& other);
  Covariance<kCandidates> mean() const;
};

/// How slices sample the axis; lengths in slice distances.
struct SliceView {
  SliceProfile profile = SliceProfile::Point;
  double thickness = 0;
};

/// The candidates' errors on slices held out from their neighbours, alternating between even and odd ones.
/// krigingBlur: in slice distances.
CandidateErrors heldOutErrors(const SliceLines& slices, const SliceView& view, double krigingBlur);

/// In-plane images along an axis, and their detail along the other.
struct InPlaneLines {
  SliceLines image, detail;
};

/// Images along one in-plane axis, blurred, and what slices that far apart would show of them.
struct DegradedImages {
  SliceLines truth, low;
  std::int64_t factor = 0; // low.length to truth.length
  std::vector<double> profile, at;
  SliceView view;
};

/// For lines of one length: the candidates as they are, and with back-projection, which is linear too, where
/// slices are thick. Empty: left out.
struct LineWeights {
  std::array<SliceWeights, kCandidates> plain, projected;
};
LineWeights lineWeights(const DegradedImages& images, double krigingBlur, int firstCandidate = 0);

/// What interpolation between a scan's slices would give if its in-plane images, blurred, lay across them.
struct SliceSimulation {
  double blur = 0; // mm
  std::vector<DegradedImages> images;
  CandidateErrors plain, projected; // against the images; with back-projection
  CandidateErrors heldOut;          // from heldOutErrors() on their slices
  double slopeSum = 0;              // of slopeShare(), over the axes that show one
  int slopes = 0;
  std::array<double, 2> change{}; // changeShare() of the detail along either axis; 0: unknown
  double weight = 1;              // by its misfit, relative to the best

  const CandidateErrors& best() const { return projected.samples > 0 ? projected : plain; }
  double slope() const { return slopes > 0 ? slopeSum / slopes : 0; }
};

/// Whether an in-plane axis is judged by: its pixels are finer than the slices' distance, or neither's are.
bool isJudgedBy(const GridGeometry& stack, int axis);

/// The images along both in-plane axes, or along the one that is judged by. blur: mm.
SliceSimulation simulateSlices(const InPlaneLines (&within)[2], const Stack& stack, double blur);

/// The weights for the images along each axis, which are of the same lengths in all simulations.
std::vector<LineWeights> weightsOfAxes(const SliceSimulation& any, double krigingBlur);

/// Adds the errors of interpolation, and of back-projection where slices are thick.
void addErrors(const DegradedImages& images, const LineWeights& weights, CandidateErrors& plain,
               CandidateErrors& projected);

/// Measures all candidates again.
void measureCandidates(SliceSimulation& simulation, double krigingBlur, std::span<const LineWeights> weights);

} // namespace innergs
