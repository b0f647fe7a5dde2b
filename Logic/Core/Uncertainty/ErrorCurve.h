#pragma once
#include <span>
#include <vector>

namespace innergs {

/// Half the width of the interval that holds 90 % of normally distributed errors, in standard deviations.
constexpr double kNinety = 1.6448536269514722;

/// An error seen where the image had this much local detail.
struct HeldOutError {
  float detail, error;
};

/// The standard deviation that errors have at a local detail, so that ± kNinety of it holds 90 % of them:
/// their 90 % quantile in bins of equally many samples, made monotonic in the detail (pool adjacent
/// violators, Ayer et al. 1955) and linear in between.
class ErrorCurve {
public:
  ErrorCurve() = default;
  explicit ErrorCurve(std::vector<HeldOutError> seen, int bins = 16);

  bool empty() const { return detail_.empty(); }
  double at(double detail) const;

private:
  std::vector<double> detail_, deviation_;
};

/// The value that a share of the numbers does not exceed. Reorders them; NaN if there are none.
double quantile(std::vector<float>& numbers, double share);

} // namespace innergs
