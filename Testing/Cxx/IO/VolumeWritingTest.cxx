#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <limits>

#ifndef _WIN32
#include <csignal>
#include <sys/resource.h>
#endif

namespace innergs::test {
namespace {

const char* const formats[] = {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"};

Volume lineOf(const std::vector<float>& voxels) {
  return {{{static_cast<std::int64_t>(voxels.size()), 1, 1}, {0, 0, 0}, {1, 1, 1}, {}}, voxels};
}

TEST(VolumeWriting, IntegersAreRounded) {
  const TemporaryFolder folder;
  const Volume volume = lineOf({0.4f, 0.5f, 1.5f, 254.6f, 17, 100.2f});
  for (const OutputType type : {OutputType::UInt8, OutputType::Int16, OutputType::UInt16, OutputType::Int32})
    for (const char* format : formats) {
      EXPECT_EQ(writeVolume(volume, folder / format, type), "");
      EXPECT_EQ(readVolume(folder / format).voxels, (std::vector<float>{0, 1, 2, 255, 17, 100})) << format;
    }
}

// Nothing is clipped or rounded silently.
TEST(VolumeWriting, IntegersThatWouldSpoilTheValuesAreRefused) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const struct {
    std::vector<float> voxels;
    OutputType type;
    const char *range, *advice;
  } cases[] = {{{0, 1e-6f, 3e-6f}, OutputType::Int16, "0 to 3e-06", "type float."},
               {{0.25f, 9, 30}, OutputType::UInt8, "0.25 to 30", "type float."},
               {{-1000, 0, 3000}, OutputType::UInt8, "-1000 to 3000", "type int16, int32 or float."},
               {{-1000, 0, 100}, OutputType::UInt16, "-1000 to 100", "type int16, int32 or float."},
               {{0, 256, 300}, OutputType::UInt8, "0 to 300", "type int16, uint16, int32 or float."},
               {{0, 40000}, OutputType::Int16, "0 to 40000", "type uint16, int32 or float."},
               {{0, 1e9f}, OutputType::Int16, "0 to 1e+09", "type int32 or float."},
               {{0, 3e9f}, OutputType::Int32, "0 to 3e+09", "type float."},
               {{0, nan, 200}, OutputType::Int16, "1 value", "type float."}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.range);
    const Error error = errorOf([&] { writeVolume(lineOf(c.voxels), folder / "a.nii", c.type); });
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_TRUE(contains(error, c.range)) << error.what();
    EXPECT_TRUE(contains(error, c.advice)) << error.what();
  }
  EXPECT_EQ(folder.fileCount(), 0);
  // Labels and binary images contain few whole numbers.
  EXPECT_EQ(writeVolume(lineOf({0, 1, 1, 0}), folder / "a.nii", OutputType::UInt8), "");
}

TEST(VolumeWriting, AnOvershootIsCutOffAndTold) {
  const TemporaryFolder folder;
  const Volume volume = lineOf({-3, 0, 100, 258.4f});
  const std::vector<float> cut{0, 0, 100, 255};
  const VoxelValues scan(std::vector<float>{0, 255});
  EXPECT_EQ(writeVolume(volume, folder / "a.nii", OutputType::UInt8, scan), "") << "of a scan that fits";
  EXPECT_EQ(readVolume(folder / "a.nii").voxels, cut);
  const std::string remark = writeVolume(volume, folder / "a.nii", OutputType::UInt8);
  EXPECT_NE(remark.find("2 of 4 values"), std::string::npos) << remark;
  EXPECT_NE(remark.find("-3 to 258.4"), std::string::npos) << remark;
  EXPECT_EQ(readVolume(folder / "a.nii").voxels, cut);
  // More than an overshoot, after a fit that nobody wants to lose.
  EXPECT_NE(writeVolume(lineOf({-90, 255}), folder / "a.nii", OutputType::UInt8, scan), "");
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
  for (const auto& tooLong : {std::string(300, 'a') + ".nii", std::string(5000, 'a') + "/a.nii"}) {
    const Error error = errorOf([&] { checkVolumePath(folder / tooLong); });
    EXPECT_EQ(error.code(), ErrorCode::Io);
  }
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
/// Makes every write beyond `bytes` of a file fail, as on a full disk.
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
