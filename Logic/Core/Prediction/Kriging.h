#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <vector>

namespace innergs {

/// Ordinary kriging along the slice axis: the best linear unbiased interpolation of a signal with covariance
/// exp(−|d|/5) at distance d, seen through a Gaussian blur, from slices that see it through their profile
/// (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eq. 2.25 and 2.41). Without blur
/// and with thin slices it is nearly linear interpolation. All lengths in slice distances.
class Kriging {
public:
  /// blur: σ of the signal's own blur; thickness: width of the box or FWHM of the Gaussian, unused for
  /// points.
  Kriging(double blur, SliceProfile profile, double thickness);

  /// row[s] += share · weight of slice s at `position`, which is in [0, row.size() − 1].
  void addWeights(double position, double share, std::span<double> row) const;

private:
  double covariance(double distance, double variance) const;
  double seen(double distance) const; // covariance of a point and a slice
  double betweenSlices(double distance) const;

  double blur_, thickness_, profileVariance_ = 0; // variance of a Gaussian profile
  bool box_;
  std::vector<double> lags_; // covariance of two slices, by their distance in slices
};

} // namespace innergs
