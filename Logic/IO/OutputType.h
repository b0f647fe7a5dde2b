#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace innergs {

/// The voxel type of a written volume.
enum class OutputType { Float32, UInt8, Int16, UInt16, Int32 };

/// What a type must be able to store: the smallest and largest finite value, whether all are whole numbers,
/// and how many are not finite.
struct VoxelValues {
  explicit VoxelValues(std::span<const float> voxels);
  void join(const VoxelValues& other);

  double low = 0, high = 0;
  double span = 0; // high - low; more where they are a part of something
  bool whole = true;
  std::int64_t notFinite = 0;
};

/// Throws Error(InvalidArgument) where an integer type would spoil the values of `what`: beyond its range by
/// more than 2 % of their span (the overshoot of an interpolation), fewer than 50 whole numbers apart
/// without being whole, or not finite.
void checkType(OutputType type, const VoxelValues& values, const std::string& what);

/// Whether the type holds what was expected, and the values reach beyond that by no more than 2 % of its
/// span.
bool isOvershoot(OutputType type, const VoxelValues& values, const VoxelValues& expected);

/// Rounded to nearest and clamped to an integer type's range.
struct IntegerVoxels {
  IntegerVoxels(std::span<const float> voxels, OutputType type);

  std::vector<std::byte> bytes;
  std::int64_t clamped = 0; // moved by more than the rounding
};

} // namespace innergs
