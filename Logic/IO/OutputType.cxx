#include "IO/OutputType.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr double overshoot = 0.02;  // of the values' span: overshoot of an interpolation beside an edge
constexpr double fewestLevels = 50; // with fewer, rounding limits the PSNR to less than 45 dB

/// Rounds and clamps; returns the number of values that were clamped.
template <typename T>
std::int64_t convert(std::span<const float> voxels, std::vector<std::byte>& bytes) {
  bytes.resize(voxels.size() * sizeof(T));
  T* out = reinterpret_cast<T*>(bytes.data());
  constexpr double low = std::numeric_limits<T>::lowest(), high = std::numeric_limits<T>::max();
  std::int64_t clamped = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const double value = std::isnan(voxels[i]) ? 0 : std::round(double(voxels[i]));
    clamped += value < low || value > high;
    out[i] = static_cast<T>(std::clamp(value, low, high));
  }
  return clamped;
}

struct IntegerType {
  OutputType type;
  const char* name;
  double low, high;
  std::int64_t (*convert)(std::span<const float> voxels, std::vector<std::byte>& bytes);
};

template <typename T>
constexpr IntegerType integerType(OutputType type, const char* name) {
  return {type, name, double(std::numeric_limits<T>::lowest()), double(std::numeric_limits<T>::max()),
          convert<T>};
}

constexpr std::array integerTypes{integerType<std::uint8_t>(OutputType::UInt8, "uint8"),
                                  integerType<std::int16_t>(OutputType::Int16, "int16"),
                                  integerType<std::uint16_t>(OutputType::UInt16, "uint16"),
                                  integerType<std::int32_t>(OutputType::Int32, "int32")};

const IntegerType* integerTypeOf(OutputType type) {
  const auto found = std::find_if(integerTypes.begin(), integerTypes.end(),
                                  [&](const IntegerType& t) { return t.type == type; });
  return found == integerTypes.end() ? nullptr : &*found;
}

bool holds(const IntegerType& type, const VoxelValues& values, double margin) {
  return std::round(values.low + margin) >= type.low && std::round(values.high - margin) <= type.high;
}

bool tooFine(const VoxelValues& values) {
  return !values.whole && values.span < fewestLevels;
}

// "int16, int32 or float"
std::string typesFor(const VoxelValues& values) {
  std::string names;
  for (const IntegerType& type : integerTypes)
    if (holds(type, values, 0) && !tooFine(values))
      names += std::string(names.empty() ? "" : ", ") + type.name;
  return names.empty() ? "float" : names + " or float";
}

} // namespace

VoxelValues::VoxelValues(std::span<const float> voxels) {
  bool any = false;
  for (const float v : voxels) {
    if (!std::isfinite(v)) {
      ++notFinite;
      continue;
    }
    low = any ? std::min<double>(low, v) : v;
    high = any ? std::max<double>(high, v) : v;
    whole = whole && v == std::round(v);
    any = true;
  }
  span = high - low;
}

void VoxelValues::join(const VoxelValues& other) {
  low = std::min(low, other.low);
  high = std::max(high, other.high);
  span = high - low;
  whole = whole && other.whole;
  notFinite += other.notFinite;
}

void checkType(OutputType type, const VoxelValues& values, const std::string& what) {
  const IntegerType* const found = integerTypeOf(type);
  if (!found) return;
  const auto refuse = [](const std::string& sentence) { throw Error(ErrorCode::InvalidArgument, sentence); };
  const std::string range = numberText(values.low) + " to " + numberText(values.high);
  if (values.notFinite > 0)
    refuse(countText(values.notFinite) + (values.notFinite == 1 ? " value of " : " values of ") + what +
           (values.notFinite == 1 ? " is" : " are") + " not finite, which " + found->name +
           " cannot hold: choose the type float.");
  if (!holds(*found, values, overshoot * values.span))
    refuse("The values of " + what + " run from " + range + " and " + found->name + " holds only " +
           countText(static_cast<std::int64_t>(found->low)) + " to " +
           countText(static_cast<std::int64_t>(found->high)) + ": choose the type " + typesFor(values) + ".");
  if (tooFine(values))
    refuse("The values of " + what + " run from " + range + ": as whole numbers (" + found->name +
           ") little or nothing of them would be left; choose the type float.");
}

bool isOvershoot(OutputType type, const VoxelValues& values, const VoxelValues& expected) {
  const double margin = overshoot * expected.span;
  const IntegerType* const integer = integerTypeOf(type);
  return values.low >= expected.low - margin && values.high <= expected.high + margin &&
         (!integer || holds(*integer, expected, 0));
}

IntegerVoxels::IntegerVoxels(std::span<const float> voxels, OutputType type) {
  if (const IntegerType* const integer = integerTypeOf(type)) clamped = integer->convert(voxels, bytes);
}

} // namespace innergs
