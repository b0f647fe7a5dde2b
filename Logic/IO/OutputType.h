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
/// and the number of non-finite values.
struct VoxelValues {
  explicit VoxelValues(std::span<const float> voxels);
  void join(const VoxelValues& other);

  double low = 0, high = 0;
  double span = 0; // high − low, or more if the values are part of a whole
  bool whole = true;
  std::int64_t notFinite = 0;
};

/// Throws Error(InvalidArgument) if an integer type would spoil the values of `what`: if they exceed its
/// range by more than 2 % of their span (the overshoot of an interpolation), span fewer than 50 whole numbers
/// without being whole, or are not finite.
void checkType(OutputType type, const VoxelValues& values, const std::string& what);

/// Whether the type fits the expected values, and the actual ones exceed those by at most 2 % of the expected
/// span.
bool isOvershoot(OutputType type, const VoxelValues& values, const VoxelValues& expected);

/// Values rounded to nearest and clamped to an integer type's range.
struct IntegerVoxels {
  IntegerVoxels(std::span<const float> voxels, OutputType type);

  std::vector<std::byte> bytes;
  std::int64_t clamped = 0; // number changed by more than rounding
};

} // namespace innergs
