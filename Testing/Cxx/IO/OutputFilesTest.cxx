#include "IO/OutputFiles.h"
#include "TestFiles.h"

#include "IO/FilePath.h"

namespace fs = std::filesystem;

namespace innergs::test {
namespace {

using Kind = OutputFiles::Kind;

class OutputFilesTest : public testing::Test {
protected:
  void SetUp() override {
    writeBytes(folder_ / "scan.nii.gz", "a scan");
    writeBytes(folder_ / "header.mhd", "ElementDataFile = header.raw\n");
    writeBytes(folder_ / "header.raw", "voxels");
    writeBytes(folder_ / "pair.hdr", "a header");
    writeBytes(folder_ / "pair.img", "voxels");
    fs::create_directories(folder_ / "dicom");
    fs::create_directories(folder_ / "sub");
    writeBytes(folder_ / "dicom/1.dcm", "a slice");
  }
  bool refused(const fs::path& input, const fs::path& output) {
    OutputFiles files;
    files.read(input);
    try {
      files.add(output);
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_NE(std::string(error.what()).find(utf8(input)), std::string::npos) << error.what();
      return true;
    }
  }
  TemporaryFolder folder_;
};

TEST_F(OutputFilesTest, AnInputIsNoOutput) {
  const fs::path scan = folder_ / "scan.nii.gz";
  EXPECT_TRUE(refused(scan, scan));
  EXPECT_TRUE(refused(scan, folder_ / "sub/../scan.nii.gz"));
  EXPECT_TRUE(refused(fs::relative(scan), scan));
  EXPECT_FALSE(refused(scan, folder_ / "other.nii.gz"));
  fs::create_hard_link(scan, folder_ / "hard.nii.gz");
  EXPECT_TRUE(refused(scan, folder_ / "hard.nii.gz"));
#ifndef _WIN32
  fs::create_symlink("scan.nii.gz", folder_ / "link.nii.gz");
  EXPECT_TRUE(refused(scan, folder_ / "link.nii.gz"));
  EXPECT_TRUE(refused(folder_ / "link.nii.gz", scan));
  fs::create_directory_symlink(folder_ / "dicom", folder_ / "series");
  EXPECT_TRUE(refused(folder_ / "series", folder_ / "dicom/1.dcm"));
#endif
  EXPECT_TRUE(refused(folder_ / "dicom", folder_ / "dicom/1.dcm"));
  EXPECT_FALSE(refused(folder_ / "dicom", folder_ / "dicom/report.json"));
  EXPECT_TRUE(refused(folder_ / "header.mhd", folder_ / "header.raw"));
  EXPECT_TRUE(refused(folder_ / "pair.hdr", folder_ / "pair.img"));
  EXPECT_TRUE(refused(folder_ / "pair.img", folder_ / "pair.hdr"));
}

TEST_F(OutputFilesTest, EachOutputHasANameOfItsOwn) {
  const auto refusedBeside = [&](const fs::path& first, const fs::path& second) {
    OutputFiles files;
    files.add(first);
    try {
      files.add(second);
      return false;
    } catch (const Error& error) {
      return std::string(error.what()).find("one file") != std::string::npos;
    }
  };
  EXPECT_TRUE(refusedBeside(folder_ / "new", folder_ / "new"));
  EXPECT_TRUE(refusedBeside(folder_ / "new", folder_ / "sub/../new"));
  EXPECT_FALSE(refusedBeside(folder_ / "new", folder_ / "newer"));
#ifndef _WIN32
  fs::create_symlink("not-yet", folder_ / "dangling");
  EXPECT_TRUE(refusedBeside(folder_ / "dangling", folder_ / "not-yet"));
  EXPECT_FALSE(refusedBeside("/dev/null", "/dev/null")); // stores nothing
#endif
}

TEST_F(OutputFilesTest, ExtensionsAreThoseOfTheKind) {
  OutputFiles files;
  const std::pair<const char*, Kind> wrong[] = {
      {"a.txt", Kind::Volume}, {"a.nii", Kind::Model}, {"a.innergs", Kind::Ply}, {"a.jpg", Kind::Png}};
  for (const auto& [name, kind] : wrong)
    EXPECT_EQ(errorOf([&, name = name, kind = kind] { files.add(folder_ / name, kind); }).code(),
              ErrorCode::InvalidArgument)
        << name;
  const std::pair<const char*, Kind> right[] = {{"a.NII", Kind::Volume},
                                                {"a.innergs", Kind::Model},
                                                {"a.PLY", Kind::Ply},
                                                {"a.png", Kind::Png},
                                                {"a", Kind::Any}};
  for (const auto& [name, kind] : right)
    EXPECT_NO_THROW(files.add(folder_ / name, kind)) << name;
  EXPECT_NO_THROW(files.add(""));
}

TEST_F(OutputFilesTest, OneFailureLeavesTheOthers) {
  OutputFiles files;
  std::vector<std::string> tried;
  const auto writer = [&](bool fails) {
    return [&tried, fails](const fs::path& path) {
      tried.push_back(utf8(path));
      if (fails) throw Error(ErrorCode::Io, "'" + utf8(path) + "' could not be written.");
    };
  };
  EXPECT_TRUE(files.write("a", writer(false)));
  EXPECT_NO_THROW(files.check());
  EXPECT_FALSE(files.write("b", writer(true)));
  EXPECT_FALSE(files.write("", writer(false)));
  EXPECT_FALSE(files.write("c", writer(true)));
  EXPECT_TRUE(files.write("d", writer(false)));
  EXPECT_EQ(tried, (std::vector<std::string>{"a", "b", "c", "d"}));
  const Error error = errorOf([&] { files.check(); });
  for (const char* part : {"'b' could not", "'c' could not", "a, d"})
    EXPECT_TRUE(contains(error, part)) << error.what();
}

} // namespace
} // namespace innergs::test
