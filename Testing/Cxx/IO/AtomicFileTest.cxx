#include "IO/AtomicFile.h"

#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <stdexcept>

#ifndef _WIN32
#include <sys/stat.h>
#include <unistd.h>
#endif
#ifdef __linux__
#include <dlfcn.h>
#endif

namespace fs = std::filesystem;

#ifdef __linux__
namespace {

struct Flushed {
  bool folder;
  std::uintmax_t bytes; // of a file
};
std::vector<Flushed> flushed;

} // namespace

/// A program's own definition takes precedence over the C library's.
extern "C" __attribute__((visibility("default"))) int fsync(int file) {
  struct stat status;
  if (fstat(file, &status) == 0)
    flushed.push_back({S_ISDIR(status.st_mode), static_cast<std::uintmax_t>(status.st_size)});
  static const auto flush = reinterpret_cast<int (*)(int)>(dlsym(RTLD_NEXT, "fsync"));
  return flush(file);
}
#endif

namespace innergs::test {
namespace {

#ifndef _WIN32
fs::perms permissions(const fs::path& path) {
  return fs::status(path).permissions();
}
#endif

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  writeFileAtomically(folder / "report.json", "first");
  writeFileAtomically(folder / "report.json", "second");
  EXPECT_EQ(readBytes(folder / "report.json"), "second");
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(AtomicFile, TemporaryLiesBesideTheTargetWithItsExtension) {
  const TemporaryFolder folder;
  fs::path seen;
  writeAtomically(folder / "sub-01.T1w.nii.gz", [&](const fs::path& temporary) {
    seen = temporary;
    writeBytes(temporary, "x");
  });
  EXPECT_EQ(seen.parent_path(), folder.path());
  EXPECT_TRUE(seen.filename().string().ends_with(".nii.gz")) << seen;
  EXPECT_NE(seen.filename(), "sub-01.T1w.nii.gz");
}

TEST(AtomicFile, AnExceptionLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  writeBytes(folder / "model.innergs", "old");
  EXPECT_THROW(writeAtomically(folder / "model.innergs",
                               [](const fs::path& temporary) {
                                 writeBytes(temporary, "half");
                                 throw std::runtime_error("stop");
                               }),
               std::runtime_error);
  EXPECT_EQ(readBytes(folder / "model.innergs"), "old");
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(AtomicFile, NothingWrittenIsAnError) {
  const TemporaryFolder folder;
  EXPECT_EQ(errorOf([&] { writeAtomically(folder / "a.ply", [](const fs::path&) {}); }).code(),
            ErrorCode::Io);
  EXPECT_EQ(folder.fileCount(), 0);
}

TEST(AtomicFile, BadFolders) {
  const TemporaryFolder folder;
  writeBytes(folder / "file", "x");
  EXPECT_EQ(errorOf([&] { writeFileAtomically(folder / "missing/a.txt", "x"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([&] { writeFileAtomically(folder / "file/a.txt", "x"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([&] { writeFileAtomically(folder.path(), "x"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([&] { checkOutputFolder(folder / "missing/a.txt"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([&] { checkOutputFolder(""); }).code(), ErrorCode::InvalidArgument);
  EXPECT_NO_THROW(checkOutputFolder(folder / "a.txt"));
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(AtomicFile, ALinkKeepsPointingAtTheNewFile) {
  const TemporaryFolder folder;
  writeBytes(folder / "real.txt", "old");
  std::error_code failed;
  fs::create_symlink(folder / "real.txt", folder / "link.txt", failed);
  if (failed) GTEST_SKIP() << "no symbolic links here";
  writeFileAtomically(folder / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
  EXPECT_EQ(readBytes(folder / "real.txt"), "new");
}

TEST(AtomicFile, ADanglingLinkGetsItsFile) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "disk");
  std::error_code failed;
  fs::create_symlink("disk/scan.nii.gz", folder / "second", failed);
  if (failed) GTEST_SKIP() << "no symbolic links here";
  fs::create_symlink("second", folder / "first.nii.gz");
  checkOutputFolder(folder / "first.nii.gz");
  writeFileAtomically(folder / "first.nii.gz", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "first.nii.gz") && fs::is_symlink(folder / "second"));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder / "disk/scan.nii.gz")));
  EXPECT_EQ(readBytes(folder / "disk/scan.nii.gz"), "new");

  fs::create_symlink(folder / "missing/file", folder / "nowhere");
  EXPECT_EQ(errorOf([&] { writeFileAtomically(folder / "nowhere", "x"); }).code(), ErrorCode::Io);
  fs::create_symlink("circle", folder / "circle");
  EXPECT_EQ(errorOf([&] { writeFileAtomically(folder / "circle", "x"); }).code(), ErrorCode::Io);
}

#ifndef _WIN32
TEST(AtomicFile, AnExistingFileKeepsItsPermissions) {
  const TemporaryFolder folder;
  for (const int mode : {0600, 0640, 0664, 0444}) {
    const fs::path file = folder / "patient.nrrd";
    writeBytes(file, "old");
    fs::permissions(file, static_cast<fs::perms>(mode));
    writeAtomically(file, [&](const fs::path& temporary) {
      EXPECT_EQ(permissions(temporary), static_cast<fs::perms>(0600)) << "others could read it meanwhile";
      writeBytes(temporary, "new");
    });
    EXPECT_EQ(permissions(file), static_cast<fs::perms>(mode));
    EXPECT_EQ(readBytes(file), "new");
    fs::remove(file);
  }
}

TEST(AtomicFile, ANewFileFollowsTheUsersMask) {
  const TemporaryFolder folder;
  for (const mode_t mask : {mode_t{022}, mode_t{077}, mode_t{002}}) {
    const mode_t before = umask(mask);
    writeFileAtomically(folder / ("new" + std::to_string(mask)), "x");
    umask(before);
    EXPECT_EQ(permissions(folder / ("new" + std::to_string(mask))), static_cast<fs::perms>(0666 & ~mask));
  }
}

TEST(AtomicFile, AnExistingFileKeepsItsOwnerAndGroupWhereAllowed) {
  if (geteuid() != 0) GTEST_SKIP() << "only the superuser may give files away";
  const TemporaryFolder folder;
  writeBytes(folder / "a", "old");
  ASSERT_EQ(chown((folder / "a").c_str(), 12345, 23456), 0);
  writeFileAtomically(folder / "a", "new");
  struct stat status;
  ASSERT_EQ(stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 12345u);
  EXPECT_EQ(status.st_gid, 23456u);
}
#endif

#ifdef __linux__
TEST(AtomicFile, IsOnTheDiskBeforeAndAfterItIsRenamed) {
  const TemporaryFolder folder;
  flushed.clear();
  writeFileAtomically(folder / "a", "seven..");
  ASSERT_EQ(flushed.size(), 2u);
  EXPECT_FALSE(flushed[0].folder);
  EXPECT_EQ(flushed[0].bytes, 7u);
  EXPECT_TRUE(flushed[1].folder);
}
#endif

TEST(AtomicFile, FullDevice) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  EXPECT_EQ(errorOf([] { writeFileAtomically("/dev/full", "text"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([] { writeAtomically("/dev/full", [](const fs::path&) {}); }).code(), ErrorCode::Io);
  EXPECT_TRUE(fs::exists("/dev/full"));
}

} // namespace
} // namespace innergs::test
