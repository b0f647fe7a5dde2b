#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <vector>

namespace innergs {

/// Ordinary kriging along the slice axis: the best linear unbiased interpolation of a signal whose covariance
/// at a distance d is exp(−|d|/5) seen through a Gaussian blur, from slices that see it through their profile
/// (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eq. 2.25 and 2.41). Without blur
/// and with thin slices it is nearly linear interpolation. All lengths in slice distances.
class Kriging {
public:
  /// blur: σ of the signal's own; thickness: width of the box or FWHM of the Gaussian, unused for points.
  Kriging(double blur, SliceProfile profile, double thickness);

  /// row[s] += share · weight of slice s at `position`, 0…row.size() − 1.
  void addWeights(double position, double share, std::span<double> row) const;

private:
  double covariance(double distance, double variance) const;
  double seen(double distance) const; // between a point and a slice
  double betweenSlices(double distance) const;

  double blur_, thickness_, profileVariance_ = 0; // of a Gaussian profile
  bool box_;
  std::vector<double> lags_; // between slices so many distances apart
};

} // namespace innergs
