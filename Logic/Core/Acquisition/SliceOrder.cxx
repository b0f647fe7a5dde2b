#include "Core/Acquisition/SliceOrder.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace innergs {
namespace {

bool arePasses(std::span<const double> times, std::size_t count) {
  std::vector<std::pair<double, double>> passes; // first and last time
  for (std::size_t k = 0; k < count; ++k) {
    passes.emplace_back(times[k], times[k]);
    for (std::size_t s = k + count; s < times.size(); s += count) {
      passes[k].first = std::min(passes[k].first, times[s]);
      passes[k].second = std::max(passes[k].second, times[s]);
    }
  }
  std::sort(passes.begin(), passes.end());
  for (std::size_t n = 1; n < count; ++n)
    if (passes[n].first <= passes[n - 1].second) return false;
  return true;
}

} // namespace

int interleavedPasses(std::span<const double> times) {
  if (times.size() < 2) return 0;
  const auto inOrder = [&](const auto& wrong) {
    return std::adjacent_find(times.begin(), times.end(), wrong) == times.end();
  };
  if (inOrder(std::greater_equal<double>()) || inOrder(std::less_equal<double>())) return 1;
  for (std::size_t count = 2; count <= times.size() / 2; ++count)
    if (arePasses(times, count)) return static_cast<int>(count);
  return 0;
}

std::string sliceOrderText(std::span<const double> times) {
  if (times.empty()) return {};
  const int passes = interleavedPasses(times);
  return passes == 0   ? "in another order"
         : passes == 1 ? "one after the other"
                       : "in " + std::to_string(passes) + " interleaved passes";
}

} // namespace innergs
