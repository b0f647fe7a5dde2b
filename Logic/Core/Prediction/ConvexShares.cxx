#include "Core/Prediction/ConvexShares.h"

#include <limits>

namespace innergs {
namespace {

constexpr int kSteps = 20; // divisions of a share

/// Visits every way to divide `left` steps among the guesses from `at` on.
template <std::size_t N, class Visit>
void visitShares(std::array<double, N>& share, std::size_t at, int left, const Visit& visit) {
  if (at + 1 == N) {
    share[at] = left / double(kSteps);
    visit(share);
    return;
  }
  for (int n = 0; n <= left; ++n) {
    share[at] = n / double(kSteps);
    visitShares(share, at + 1, left - n, visit);
  }
}

} // namespace

template <std::size_t N>
std::array<double, N> convexShares(const std::function<double(const std::array<double, N>&)>& cost) {
  std::array<double, N> chosen{1}, share{};
  double least = std::numeric_limits<double>::infinity();
  visitShares(share, 0, kSteps, [&](const std::array<double, N>& tried) {
    const double c = cost(tried);
    if (!(c < least)) return;
    least = c;
    chosen = tried;
  });
  return chosen;
}

template <std::size_t N>
std::array<double, N> convexShares(const Covariance<N>& errors) {
  return convexShares<N>([&](const std::array<double, N>& share) { return meanSquare(errors, share); });
}

template std::array<double, 3> convexShares(const std::function<double(const std::array<double, 3>&)>& cost);
template std::array<double, 4> convexShares(const std::function<double(const std::array<double, 4>&)>& cost);
template std::array<double, 3> convexShares(const Covariance<3>& errors);
template std::array<double, 4> convexShares(const Covariance<4>& errors);

} // namespace innergs
