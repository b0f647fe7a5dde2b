#pragma once
#include <span>
#include <vector>

namespace innergs {

/// Half the width of the interval that holds 90 % of normally distributed errors, in standard deviations.
constexpr double kNinety = 1.6448536269514722;

/// An error seen where the image had this much local detail.
struct SeenError {
  float detail, error;
};

/// The standard deviation that errors have at a local detail, so that ± kNinety of it holds 90 % of them: in
/// bins of equally many samples their 90 % quantile, made to grow with the detail (pooling of adjacent
/// violators), and linear in between.
class ErrorCurve {
public:
  ErrorCurve() = default;
  explicit ErrorCurve(std::vector<SeenError> seen, int bins = 16);

  bool empty() const { return detail_.empty(); }
  double at(double detail) const;

private:
  std::vector<double> detail_, deviation_;
};

/// The value that a share of the numbers does not exceed. Reorders them; NaN if there are none.
double quantile(std::vector<float>& numbers, double share);

} // namespace innergs
