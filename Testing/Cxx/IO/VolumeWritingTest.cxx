#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <cmath>
#include <limits>

#ifndef _WIN32
#include <csignal>
#include <sys/resource.h>
#endif

namespace innergs::test {
namespace {

const char* const formats[] = {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"};

TEST(VolumeWriting, IntegersAreRoundedAndClamped) {
  const TemporaryFolder folder;
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const Volume volume{{{4, 2, 2}, {0, 0, 0}, {1, 1, 1}, {}},
                      {0.4f, 0.5f, 1.5f, -0.5f, -0.4f, 254.6f, 255.4f, 256, -40000, 40000, 70000, -3e9f, 3e9f,
                       inf, -inf, nan}};
  const auto expected = [&](double low, double high) {
    std::vector<float> values;
    for (const float v : volume.voxels)
      values.push_back(
          std::isnan(v) ? 0 : static_cast<float>(std::fmin(std::fmax(std::round(double(v)), low), high)));
    return values;
  };
  const std::tuple<OutputType, double, double> types[] = {{OutputType::UInt8, 0, 255},
                                                          {OutputType::Int16, -32768, 32767},
                                                          {OutputType::UInt16, 0, 65535},
                                                          {OutputType::Int32, -2147483648.0, 2147483647.0}};
  for (const auto& [type, low, high] : types)
    for (const char* format : formats) {
      writeVolume(volume, folder / format, type);
      EXPECT_EQ(readVolume(folder / format).voxels, expected(low, high)) << format << " " << low;
    }
}

TEST(VolumeWriting, StoredTypesAndCompression) {
  const TemporaryFolder folder;
  const Volume volume{{{40, 40, 40}, {0, 0, 0}, {1, 1, 1}, {}}, std::vector<float>(64000, 7)};
  for (const char* format : {"a.nii.gz", "a.nrrd", "a.mha"}) {
    writeVolume(volume, folder / format);
    EXPECT_LT(std::filesystem::file_size(folder / format), 20000u) << format;
  }
  writeVolume(volume, folder / "a.nii", OutputType::Int16);
  EXPECT_EQ(std::filesystem::file_size(folder / "a.nii"), 352u + 128000u);
}

TEST(VolumeWriting, PathsAreCheckedBeforehand) {
  const TemporaryFolder folder;
  for (const char* name : {"a.jpg", "a", "a.gz", "a.nhdr", "a.mnc", "a.nii.bz2"})
    EXPECT_EQ(errorOf([&] { checkVolumePath(folder / name); }).code(), ErrorCode::InvalidArgument) << name;
  EXPECT_EQ(errorOf([&] { checkVolumePath(folder / "missing/a.nii"); }).code(), ErrorCode::Io);
  writeBytes(folder / "file", "x");
  EXPECT_EQ(errorOf([&] { checkVolumePath(folder / "file/a.nii"); }).code(), ErrorCode::Io);
  for (const char* format : formats)
    EXPECT_NO_THROW(checkVolumePath(folder / format));
  EXPECT_NO_THROW(checkVolumePath(folder / "A.NII.GZ"));
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(VolumeWriting, BadVolumes) {
  const TemporaryFolder folder;
  const Volume shorter{{{2, 2, 2}, {0, 0, 0}, {1, 1, 1}, {}}, {1, 2, 3}};
  EXPECT_EQ(errorOf([&] { writeVolume(shorter, folder / "a.nii"); }).code(), ErrorCode::InvalidArgument);
  const Volume flat{{{2, 2, 0}, {0, 0, 0}, {1, 1, 1}, {}}, {}};
  EXPECT_EQ(errorOf([&] { writeVolume(flat, folder / "a.nii"); }).code(), ErrorCode::Geometry);
  const Volume wide{{{40000, 1, 1}, {0, 0, 0}, {1, 1, 1}, {}}, std::vector<float>(40000, 1)};
  EXPECT_EQ(errorOf([&] { writeVolume(wide, folder / "a.nii"); }).code(), ErrorCode::InvalidArgument);
  EXPECT_NO_THROW(writeVolume(wide, folder / "a.nrrd"));
  EXPECT_EQ(folder.fileCount(), 1);
}

#ifndef _WIN32
/// Makes every write behind `bytes` of a file fail, as on a full disk.
class FileSizeLimit {
public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(VolumeWriting, AFullDiskLeavesTheOldFileAndNothingElse) {
  Volume volume{{{64, 64, 64}, {0, 0, 0}, {1, 1, 1}, {}}, {}};
  std::mt19937 random(5);
  for (int n = 0; n < 64 * 64 * 64; ++n)
    volume.voxels.push_back(static_cast<float>(random()));
  for (const char* format : formats)
    for (const rlim_t limit : {rlim_t{0}, rlim_t{300}, rlim_t{20000}, rlim_t{400000}}) {
      SCOPED_TRACE(std::string(format) + " " + std::to_string(limit));
      const TemporaryFolder folder;
      writeBytes(folder / format, "the old file");
      {
        const FileSizeLimit full(limit);
        EXPECT_EQ(errorOf([&] { writeVolume(volume, folder / format); }).code(), ErrorCode::Io);
      }
      EXPECT_EQ(readBytes(folder / format), "the old file");
      EXPECT_EQ(folder.fileCount(), 1);
    }
}
#endif

} // namespace
} // namespace innergs::test
