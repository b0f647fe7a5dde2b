#include "Core/Prediction/PredictionShares.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr double kHedge = 0.03;     // share of interpolation's squared error, added to each guess's
constexpr double kLeastShare = 0.1; // of a guess; less is not worth its time
constexpr double kLeastRest = 0.3;  // share of interpolation; with less, what is learned replaces it
constexpr double kUsualRise = 1.08; // in learnedRise(): up to here, the scan's own trial is trusted

} // namespace

std::array<double, 3> predictionShares(Covariance<3> errors, const std::array<bool, 3>& exists,
                                       const std::array<double, 3>& rise) {
  const double hedge = kHedge * errors[0][0]; // measured at twice the distance, so hedged towards all
  for (int n = 0; n < 3; ++n)
    for (int m = 0; m < 3; ++m)
      errors[n][m] *= rise[n] * rise[m];
  for (int n = 1; n < 3; ++n)
    if (!exists[n])
      for (int m = 0; m < 3; ++m)
        errors[n][m] = errors[m][n] = m == n ? 1e6 * errors[0][0] : 0;
  for (int n = 0; n < 3; ++n)
    errors[n][n] += hedge;
  std::array<double, 3> share = convexShares<3>(errors);
  for (int n = 1; n < 3; ++n)
    if (!exists[n] || share[n] < kLeastShare) {
      share[0] += share[n];
      share[n] = 0;
    }
  if (share[1] > 0 && share[2] > 0) { // they err differently; the field suffers at twice the distance
    const double both = share[1] + share[2];
    share[1] = 0.5 * share[1] + 0.25 * both;
    share[2] = both - share[1];
  }
  if (share[1] == 0 && share[0] < kLeastRest) { // learning suffers most at twice the distance
    share[2] += share[0];
    share[0] = 0;
  }
  return share;
}

double learnedRise(const PairErrors& twice, const PairErrors& once) {
  if (!(twice.network > 0 && once.linear > 0)) return 1;
  return std::max(1.0, once.network / once.linear * twice.linear / twice.network / kUsualRise);
}

} // namespace innergs
