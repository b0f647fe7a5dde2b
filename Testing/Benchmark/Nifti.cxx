#include "Nifti.h"

#include "Core/Base/Error.h"

#include <cstring>
#include <fstream>
#include <iterator>

namespace innergs::bench {
namespace {

template <class T>
T at(const std::vector<char>& bytes, std::size_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

} // namespace

Volume readPlainNifti(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  constexpr std::size_t header = 348;
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::InvalidArgument,
                path + " " + why + ": give an uncompressed three-dimensional NIfTI-1 file (.nii).");
  };
  if (bytes.size() < header) refuse("cannot be read");
  if (at<std::int32_t>(bytes, 0) != static_cast<int>(header)) refuse("is no such file");
  Volume volume;
  for (int a = 0; a < 3; ++a) {
    volume.geometry.size[a] = at<std::int16_t>(bytes, 42 + 2 * a);
    volume.geometry.spacing[a] = at<float>(bytes, 80 + 4 * a);
    if (volume.geometry.size[a] < 1 || !(volume.geometry.spacing[a] > 0)) refuse("has no size");
  }
  const int type = at<std::int16_t>(bytes, 70);
  const std::size_t size = type == 2 ? 1 : type == 4 ? 2 : type == 16 ? 4 : 0;
  if (size == 0) refuse("has voxels of another type");
  const auto first = static_cast<std::size_t>(at<float>(bytes, 108));
  const auto count = static_cast<std::size_t>(volume.geometry.voxelCount());
  if (first < header || (bytes.size() - header) / size < count || bytes.size() - size * count < first)
    refuse("is too short");
  float slope = at<float>(bytes, 112);
  const float offset = slope == 0 ? 0 : at<float>(bytes, 116);
  if (slope == 0) slope = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = first + size * i;
    const float x = type == 2   ? at<std::uint8_t>(bytes, place)
                    : type == 4 ? at<std::int16_t>(bytes, place)
                                : at<float>(bytes, place);
    volume.voxels.push_back(slope * x + offset);
  }
  return volume;
}

} // namespace innergs::bench
