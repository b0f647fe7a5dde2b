#include "SyntheticImages.h"

#include <cmath>
#include <cstring>

namespace innergs::test {
namespace {

/// valueOf: a voxel's by its squared distance (mm²) from the blob's centre.
template <class ValueOf>
TimeSeries blobSeries(int frames, const ValueOf& valueOf) {
  TimeSeries series;
  series.geometry.size = {16, 12, 5};
  for (int f = 0; f < frames; ++f) {
    auto& frame = series.frames.emplace_back();
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 16; ++i)
          frame.push_back(static_cast<float>(
              valueOf(std::pow(i - 5 - 0.8 * f, 2) + std::pow(j - 6, 2) + std::pow(k - 2, 2))));
    series.times.push_back(0.5 * f);
  }
  return series;
}

} // namespace

Volume phantom(std::array<std::int64_t, 3> size, double dz) {
  Volume volume;
  volume.geometry.size = size;
  volume.geometry.spacing = {1, 1, dz};
  volume.geometry.origin = {-11, 7, 30};
  const double c = std::cos(0.2), s = std::sin(0.2);
  volume.geometry.direction.m = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
  const Vec3 half{0.5 * (size[0] - 1.0), 0.5 * (size[1] - 1.0), 0.5 * (size[2] - 1.0)};
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const double x = (i - half[0]) / half[0], y = (j - half[1]) / half[1], z = (k - half[2]) / half[2];
        const double r = std::sqrt(x * x + y * y + z * z);
        const double head = 1 / (1 + std::exp(12 * (r - 0.8)));
        const double structure = 0.6 + 0.25 * std::sin(5 * x + 2 * z) * std::cos(4 * y - z);
        volume.voxels.push_back(static_cast<float>(1000 * head * structure));
      }
  return volume;
}

TimeSeries movingBlob(int frames) {
  return blobSeries(frames, [](double square) { return 100 * std::exp(-0.1 * square); });
}

TimeSeries movingBlobLabels(int frames) {
  return blobSeries(frames, [](double square) { return square < 9 ? 1 : 0; });
}

std::string MetaImage::bytes() const {
  std::size_t count = 1;
  std::string sizes;
  for (const int n : size) {
    count *= n;
    sizes += " " + std::to_string(n);
  }
  std::string file = "ObjectType = Image\nNDims = " + std::to_string(size.size()) +
                     "\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
                     "TransformMatrix = " +
                     matrix + "\nOffset = " + offset + "\nElementSpacing = " + spacing +
                     "\nDimSize =" + sizes + "\n";
  if (channels > 1) file += "ElementNumberOfChannels = " + std::to_string(channels) + "\n";
  file += "ElementType = " + type + "\nElementDataFile = LOCAL\n";
  for (std::size_t n = 0; n < count; ++n) {
    const float value = values.empty() ? static_cast<float>(n % 97) : values[n % values.size()];
    for (int channel = 0; channel < channels; ++channel) {
      if (type == "MET_UCHAR") {
        file += static_cast<char>(static_cast<unsigned char>(value));
      } else {
        char raw[sizeof(float)];
        std::memcpy(raw, &value, sizeof(raw));
        file.append(raw, sizeof(raw));
      }
    }
  }
  return file;
}

std::string niftiBytes(const std::vector<int>& size, int datatype, int bits) {
  std::string file(352, '\0');
  const auto put = [&](std::size_t offset, auto value) {
    std::memcpy(file.data() + offset, &value, sizeof(value));
  };
  put(0, std::int32_t{348});
  put(40, static_cast<std::int16_t>(size.size()));
  std::size_t count = 1;
  for (std::size_t d = 0; d < 7; ++d) {
    const int n = d < size.size() ? size[d] : 1;
    put(42 + 2 * d, static_cast<std::int16_t>(n));
    put(80 + 4 * d, 1.0f);
    count *= n;
  }
  put(70, static_cast<std::int16_t>(datatype));
  put(72, static_cast<std::int16_t>(bits));
  put(76, 1.0f);             // qfac
  put(108, 352.0f);          // vox_offset
  put(123, char{2});         // mm
  put(252, std::int16_t{1}); // qform: scanner
  std::memcpy(file.data() + 344, "n+1", 4);
  file.append(count * bits / 8, '\0');
  return file;
}

} // namespace innergs::test
