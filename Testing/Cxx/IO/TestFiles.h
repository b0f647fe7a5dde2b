#pragma once
#include "../Core/ThrownError.h"
#include "Core/Image/Volume.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <string_view>

namespace innergs::test {

/// An empty folder that is removed at the end of the test.
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::random_device random;
    path_ = std::filesystem::temp_directory_path() /
            ("innergs-test-" + std::to_string(random()) + std::to_string(random()));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  /// Files in the folder, including hidden ones.
  int fileCount() const {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      count += entry.exists();
    return count;
  }

private:
  std::filesystem::path path_;
};

inline void writeBytes(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(out.good()) << path;
}

inline std::string readBytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline std::filesystem::path dataFile(const std::string& name) {
  return std::filesystem::path(INNERGS_TEST_DATA) / name;
}

/// Skips the test if a real volume is not available on this machine.
#define INNERGS_NEED(name)                                                                                   \
  if (!std::filesystem::exists(innergs::test::dataFile(name)))                                               \
  GTEST_SKIP() << (name) << " is not in " INNERGS_TEST_DATA

/// The bytes of a NIfTI-1 header (.nii, uint8, 1 mm, identity in RAS) with fields to change.
class NiftiBytes {
public:
  NiftiBytes(std::int16_t ni, std::int16_t nj, std::int16_t nk) : bytes_(352, '\0') {
    set<std::int32_t>(0, 348);
    for (int axis = 0; axis < 8; ++axis) {
      set<std::int16_t>(40 + 2 * axis, 1);
      set<float>(76 + 4 * axis, 1);
    }
    set<std::int16_t>(40, 3).set<std::int16_t>(42, ni).set<std::int16_t>(44, nj).set<std::int16_t>(46, nk);
    type(2, 8);
    set<float>(108, 352);
    bytes_[123] = 10; // mm, s
    set<std::int16_t>(254, 1);
    for (int row = 0; row < 3; ++row)
      set<float>(280 + 20 * row, 1);
    std::memcpy(bytes_.data() + 344, "n+1", 4);
  }
  template <typename T>
  NiftiBytes& set(int offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof(T));
    return *this;
  }
  NiftiBytes& type(std::int16_t code, std::int16_t bits) {
    return set<std::int16_t>(70, code).set<std::int16_t>(72, bits);
  }
  std::string with(const std::string& voxels) const { return bytes_ + voxels; }

private:
  std::string bytes_;
};

template <typename T>
std::string rawBytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A smooth blob whose centre of mass marks a point in space.
inline Volume blob(const GridGeometry& geometry, const Vec3& centre, double sigma) {
  Volume volume{geometry, {}};
  const Affine3 toWorld = geometry.indexToWorld();
  for (std::int64_t k = 0; k < geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < geometry.size[0]; ++i) {
        const Vec3 d = toWorld({double(i), double(j), double(k)}) - centre;
        volume.voxels.push_back(static_cast<float>(1000 * std::exp(-0.5 * dot(d, d) / (sigma * sigma))));
      }
  return volume;
}

inline Vec3 centreOfMass(const Volume& volume) {
  const Affine3 toWorld = volume.geometry.indexToWorld();
  Vec3 sum{0, 0, 0};
  double total = 0;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < volume.geometry.size[2]; ++k)
    for (std::int64_t j = 0; j < volume.geometry.size[1]; ++j)
      for (std::int64_t i = 0; i < volume.geometry.size[0]; ++i) {
        const double value = volume.voxels[at++];
        sum = sum + value * toWorld({double(i), double(j), double(k)});
        total += value;
      }
  return (1 / total) * sum;
}

} // namespace innergs::test
