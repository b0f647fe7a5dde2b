#include "IO/AtomicFile.h"

#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <stdexcept>

namespace fs = std::filesystem;

namespace innergs::test {
namespace {

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

TEST(AtomicFile, FullDevice) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  EXPECT_EQ(errorOf([] { writeFileAtomically("/dev/full", "text"); }).code(), ErrorCode::Io);
  EXPECT_EQ(errorOf([] { writeAtomically("/dev/full", [](const fs::path&) {}); }).code(), ErrorCode::Io);
  EXPECT_TRUE(fs::exists("/dev/full"));
}

} // namespace
} // namespace innergs::test
