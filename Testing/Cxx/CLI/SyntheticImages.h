#pragma once
#include "Core/Image/Volume.h"
#include "Core/Motion/TimeSeries.h"

#include <string>
#include <vector>

namespace innergs::test {

/// A smooth head-like phantom, values about 0 to 1000, oblique in space, spacing 1×1×`dz` mm.
Volume phantom(std::array<std::int64_t, 3> size = {24, 28, 20}, double dz = 1);

/// A blob on 16×12×5 voxels that moves along x, 0.5 s per frame.
TimeSeries movingBlob(int frames);
/// 1 within 3 mm of its centre, else 0.
TimeSeries movingBlobLabels(int frames);

/// A MetaImage (.mha) with exactly this header: for files that no careful writer would produce.
struct MetaImage {
  std::vector<int> size{12, 12, 8};
  std::string spacing = "1 1 1";
  std::string matrix = "1 0 0 0 1 0 0 0 1";
  std::string offset = "0 0 0";
  std::string type = "MET_FLOAT"; // MET_FLOAT or MET_UCHAR
  int channels = 1;
  std::vector<float> values; // one per voxel, repeated for the channels; empty: a ramp
  std::string bytes() const;
};

/// A little-endian single-file NIfTI-1 with this datatype code and bits per voxel, voxels 0.
std::string niftiBytes(const std::vector<int>& size, int datatype, int bits);

} // namespace innergs::test
