#include "Core/Acquisition/BlankSlices.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace innergs {
namespace {

constexpr double kAirShare = 0.1;   // of the usual difference from the blank value, up to which it may be air
constexpr double kLeastBody = 0.01; // of a slice's pixels
constexpr double kSamePlace = 0.5;  // of the smaller body's pixels
constexpr double kMostShare = 0.1;  // of the slices
constexpr std::size_t kMostShown = 10;

/// The value of all the finite voxels; nothing if they differ, or there are none.
std::optional<float> singleValue(std::span<const float> slice) {
  std::optional<float> value;
  for (const float v : slice) {
    if (!std::isfinite(v)) continue;
    if (value && v != *value) return std::nullopt;
    value = v;
  }
  return value;
}

/// 1 where a slice clearly differs from the value.
std::vector<std::uint8_t> bodyIn(std::span<const float> slice, float value) {
  std::vector<float> differences;
  for (const float v : slice)
    if (std::isfinite(v)) differences.push_back(std::abs(v - value));
  std::vector<std::uint8_t> body(slice.size(), 0);
  if (differences.empty()) return body;
  const auto high =
      differences.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(differences.size() - 1));
  std::nth_element(differences.begin(), high, differences.end());
  const double different = kAirShare * *high;
  for (std::size_t p = 0; p < slice.size(); ++p)
    body[p] = std::isfinite(slice[p]) && std::abs(slice[p] - value) > different;
  return body;
}

} // namespace

std::vector<std::int64_t> blankSlices(const Stack& scan) {
  const auto& n = scan.image.geometry.size;
  const auto plane = static_cast<std::size_t>(n[0] * n[1]);
  const auto sliceAt = [&](std::int64_t k) {
    return std::span<const float>(scan.image.voxels.data() + static_cast<std::size_t>(k) * plane, plane);
  };
  std::vector<std::optional<float>> value;
  for (std::int64_t k = 0; k < n[2]; ++k)
    value.push_back(singleValue(sliceAt(k)));
  std::vector<std::int64_t> blank;
  for (std::int64_t k = 1; k + 1 < n[2]; ++k) {
    if (!value[k]) continue;
    std::int64_t below = k - 1, above = k + 1;
    while (below >= 0 && value[below] == value[k])
      --below;
    while (above < n[2] && value[above] == value[k])
      ++above;
    if (below < 0 || above >= n[2]) continue;
    const std::vector<std::uint8_t> a = bodyIn(sliceAt(below), *value[k]),
                                    b = bodyIn(sliceAt(above), *value[k]);
    const auto fewer = std::min(std::count(a.begin(), a.end(), 1), std::count(b.begin(), b.end(), 1));
    std::int64_t both = 0;
    for (std::size_t p = 0; p < plane; ++p)
      both += a[p] && b[p];
    if (static_cast<double>(fewer) >= kLeastBody * static_cast<double>(plane) &&
        static_cast<double>(both) >= kSamePlace * static_cast<double>(fewer))
      blank.push_back(k);
  }
  if (static_cast<double>(blank.size()) > kMostShare * static_cast<double>(n[2])) return {};
  return blank;
}

std::string blankSlicesSentence(std::span<const std::int64_t> slices, const std::string& name) {
  if (slices.empty()) return {};
  const bool one = slices.size() == 1;
  std::string text = one ? "Slice" : "Slices";
  for (std::size_t n = 0; n < std::min(slices.size(), kMostShown); ++n)
    text += (n == 0 ? " " : ", ") + std::to_string(slices[n]);
  if (slices.size() > kMostShown) text += " and " + std::to_string(slices.size() - kMostShown) + " more";
  return text + " of " + name + (one ? " is" : " are") +
         " blank between slices that show the body (counted from 0): " + (one ? "it was" : "they were") +
         " left out.";
}

} // namespace innergs
