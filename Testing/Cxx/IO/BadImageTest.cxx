#include "IO/VolumeIO.h"
#include "TestFiles.h"

namespace fs = std::filesystem;

namespace innergs::test {
namespace {

const float nan32 = std::numeric_limits<float>::quiet_NaN();

std::string meta(const std::string& fields, std::size_t voxelBytes = 8) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + fields +
         "\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
         std::string(voxelBytes, '\1');
}

std::string nrrd(const std::string& fields, std::size_t voxelBytes = 8) {
  return "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\n" + fields + "\nencoding: raw\n\n" +
         std::string(voxelBytes, '\1');
}

class BadImage : public testing::Test {
protected:
  ErrorCode codeOf(const std::string& name, const std::string& bytes) {
    writeBytes(folder / name, bytes);
    return codeOf(folder / name);
  }
  ErrorCode codeOf(const fs::path& path) {
    const Error error = errorOf([&] { readVolume(path); });
    EXPECT_TRUE(contains(error, path.filename().string())) << error.what();
    return error.code();
  }
  TemporaryFolder folder;
};

TEST_F(BadImage, MissingEmptyOrNoImage) {
  EXPECT_EQ(codeOf(folder / "missing.nii.gz"), ErrorCode::FileNotFound);
  for (const char* extension :
       {".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".mnc", ".dcm", ".hdr", ".txt", ""}) {
    SCOPED_TRACE(extension);
    const std::string name = "file" + std::string(extension);
    EXPECT_EQ(codeOf(name, ""), ErrorCode::FileFormat);
    EXPECT_EQ(codeOf(name, "This is text = no image.\n"), ErrorCode::FileFormat);
    EXPECT_EQ(codeOf(name, std::string(5000, '\xAB')), ErrorCode::FileFormat);
    EXPECT_EQ(codeOf(name, std::string(5000, '\0')), ErrorCode::FileFormat);
  }
  EXPECT_EQ(codeOf(folder.path()), ErrorCode::FileFormat); // a folder without DICOM
}

TEST_F(BadImage, MagicNumberOfAnotherKind) {
  EXPECT_EQ(codeOf("a.nrrd", "NRRD0004\nnonsense\n\n"), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.mnc", "\x89HDF\r\n\x1a\n" + std::string(3000, '\3')), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.dcm", std::string(128, '\0') + "DICM" + std::string(3000, '\7')),
            ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.mnc", "CDF\x01" + std::string(300, '\0')), ErrorCode::UnsupportedImage);
}

TEST_F(BadImage, PixelsThatAreNotOneNumber) {
  EXPECT_EQ(codeOf("rgb.nii", NiftiBytes(2, 2, 2).type(128, 24).with(std::string(24, '\1'))),
            ErrorCode::UnsupportedImage);
  EXPECT_EQ(codeOf("complex.nii", NiftiBytes(2, 2, 2).type(32, 64).with(std::string(64, '\1'))),
            ErrorCode::UnsupportedImage);
  EXPECT_EQ(codeOf("long.nii", NiftiBytes(2, 2, 2).type(1536, 128).with(std::string(128, '\1'))),
            ErrorCode::UnsupportedImage);
  NiftiBytes vectors(2, 2, 2);
  vectors.set<std::int16_t>(40, 5).set<std::int16_t>(50, 3).set<std::int16_t>(68, 1007);
  EXPECT_EQ(codeOf("vector.nii", vectors.with(std::string(24, '\1'))), ErrorCode::UnsupportedImage);
  EXPECT_EQ(codeOf("vector.mha", meta("ElementNumberOfChannels = 3", 24)), ErrorCode::UnsupportedImage);
  EXPECT_EQ(
      codeOf("rgb.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain domain domain\n"
             "encoding: raw\n\n" +
                 std::string(24, '\1')),
      ErrorCode::UnsupportedImage);
  EXPECT_EQ(
      codeOf("flat.mha",
             "ObjectType = Image\nNDims = 2\nBinaryData = True\nDimSize = 2 2\nElementType = MET_UCHAR\n"
             "ElementDataFile = LOCAL\n1234"),
      ErrorCode::UnsupportedImage);
}

TEST_F(BadImage, LongLineInNrrd) { // NrrdIO aborts the process on such lines
  const std::string noise(1800, '?');
  EXPECT_EQ(codeOf("a.nrrd", nrrd(noise)), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.nrrd", nrrd("space: " + noise)), ErrorCode::FileFormat);
  writeBytes(folder / "a.nrrd", nrrd("# " + noise + "\nSegment0_Name:=" + noise));
  EXPECT_EQ(readVolume(folder / "a.nrrd").voxels.size(), 8u);
}

TEST_F(BadImage, SpacingOfNifti) {
  for (const float spacing : {0.f, -1.f, nan32, std::numeric_limits<float>::infinity()})
    for (int axis = 0; axis < 3; ++axis) {
      NiftiBytes header(2, 2, 2);
      header.set<float>(80 + 4 * axis, spacing);
      EXPECT_EQ(codeOf("a.nii", header.with(std::string(8, '\1'))), ErrorCode::Geometry)
          << spacing << " " << axis;
    }
}

TEST_F(BadImage, SpacingOfMetaImageAndNrrd) {
  for (const char* spacing : {"1 0 1", "1 -1 1", "nan 1 1", "1 1 inf"}) {
    EXPECT_EQ(codeOf("a.mha", meta("ElementSpacing = " + std::string(spacing))), ErrorCode::Geometry)
        << spacing;
    EXPECT_EQ(codeOf("a.nrrd", nrrd("spacings: " + std::string(spacing))), ErrorCode::Geometry) << spacing;
  }
  const std::string space = "space: left-posterior-superior\nspace origin: (0,0,0)\nspace directions: ";
  for (const char* directions : {"(0,0,0) (0,1,0) (0,0,1)", "(nan,0,0) (0,1,0) (0,0,1)",
                                 "(inf,0,0) (0,1,0) (0,0,1)", "(1,0,0) (0,1,0) (nan,nan,nan)"})
    EXPECT_EQ(codeOf("a.nrrd", nrrd(space + directions)), ErrorCode::Geometry) << directions;
}

TEST_F(BadImage, Origin) {
  EXPECT_EQ(codeOf("a.mha", meta("Offset = nan 0 0")), ErrorCode::Geometry);
  EXPECT_EQ(
      codeOf("a.nrrd", nrrd("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                            "space origin: (0,inf,0)")),
      ErrorCode::Geometry);
  EXPECT_EQ(codeOf("a.nii", NiftiBytes(2, 2, 2).set<float>(292, nan32).with(std::string(8, '\1'))),
            ErrorCode::Geometry);
}

TEST_F(BadImage, ShearedOrSingularDirection) {
  EXPECT_EQ(codeOf("a.mha", meta("TransformMatrix = 1 0 0 1 0 0 0 0 1")), ErrorCode::Geometry);
  EXPECT_EQ(codeOf("a.mha", meta("TransformMatrix = 1 0 0 0.6 0.8 0 0 0 1")), ErrorCode::Geometry);
  EXPECT_EQ(codeOf("a.mha", meta("TransformMatrix = 1 0 0 0 1 0 0 0 0")), ErrorCode::Geometry);
  EXPECT_EQ(codeOf("a.mha", meta("TransformMatrix = 1 0 0 0 nan 0 0 0 1")), ErrorCode::Geometry);
  const std::string space = "space: left-posterior-superior\nspace origin: (0,0,0)\nspace directions: ";
  EXPECT_EQ(codeOf("a.nrrd", nrrd(space + "(1,0,0) (1,0,0) (0,0,1)")), ErrorCode::Geometry);
  EXPECT_EQ(codeOf("a.nrrd", nrrd(space + "(1,0,0) (0.6,0.8,0) (0,0,1)")), ErrorCode::Geometry);

  NiftiBytes sheared(2, 2, 2); // sform only
  sheared.set<float>(284, 0.6f).set<float>(300, 0.8f);
  EXPECT_EQ(codeOf("a.nii", sheared.with(std::string(8, '\1'))), ErrorCode::Geometry);
  sheared.set<std::int16_t>(252, 1); // with a valid qform, which ITK would silently use
  EXPECT_EQ(codeOf("a.nii", sheared.with(std::string(8, '\1'))), ErrorCode::Geometry);
  sheared.set<std::int16_t>(254, 4); // sform to MNI space: the geometry is the scanner's qform
  writeBytes(folder / "a.nii", sheared.with(std::string(8, '\1')));
  EXPECT_EQ(readVolume(folder / "a.nii").geometry.direction, diagonal({-1, -1, 1}));
  NiftiBytes singular(2, 2, 2);
  singular.set<float>(280, 0);
  EXPECT_EQ(codeOf("a.nii", singular.with(std::string(8, '\1'))), ErrorCode::Geometry);
}

TEST_F(BadImage, Truncated) {
  GridGeometry geometry{{20, 20, 20}, {0, 0, 0}, {1, 1, 1}, {}};
  Volume volume{geometry, {}};
  std::mt19937 random(3);
  for (int n = 0; n < 8000; ++n)
    volume.voxels.push_back(static_cast<float>(random() % 1000));
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    writeVolume(volume, folder / name);
    const std::string whole = readBytes(folder / name);
    for (const double part : {0.999, 0.9, 0.5, 0.1}) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(part));
      EXPECT_EQ(codeOf(name, whole.substr(0, static_cast<std::size_t>(part * double(whole.size())))),
                ErrorCode::FileFormat);
    }
    std::string broken = whole;
    for (std::size_t n = whole.size() / 2; n < whole.size() / 2 + 40; ++n)
      broken[n] = static_cast<char>(~broken[n]);
    if (std::string(name) != "a.nii") {
      EXPECT_EQ(codeOf(name, broken), ErrorCode::FileFormat) << name;
    }
  }
  EXPECT_EQ(codeOf("raw.mha", meta("", 7)), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("raw.nrrd", nrrd("", 7)), ErrorCode::FileFormat);
}

TEST_F(BadImage, HeadersThatClaimTooMuch) {
  EXPECT_EQ(codeOf("a.nii", NiftiBytes(32767, 32767, 32767).with("x")), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.nrrd",
                   "NRRD0004\ntype: double\ndimension: 3\nsizes: 100000 100000 100000\nencoding: raw\n\nx"),
            ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("a.mha",
                   "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 100000 100000 100000\n"
                   "ElementType = MET_DOUBLE\nElementDataFile = LOCAL\nx"),
            ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("b.mha", "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 0 5 -3\n"
                            "ElementType = MET_DOUBLE\nElementDataFile = LOCAL\nx"),
            ErrorCode::Geometry);
  NiftiBytes negative(2, -2, 2);
  EXPECT_EQ(codeOf("b.nii", negative.with(std::string(8, '\1'))), ErrorCode::FileFormat);
}

TEST_F(BadImage, FormatsWithoutADefinedOrientation) {
  NiftiBytes analyze(2, 2, 2);
  analyze.set<std::int32_t>(344, 0);
  EXPECT_EQ(codeOf("a.hdr", analyze.with("")), ErrorCode::UnsupportedImage);
  EXPECT_EQ(codeOf("a.nii", std::string("\x1c\x02\0\0n+2\0", 8) + std::string(600, '\0')),
            ErrorCode::UnsupportedImage);
}

TEST_F(BadImage, DetachedVoxelsMissing) {
  EXPECT_EQ(codeOf("a.nhdr",
                   "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: a.raw\n"),
            ErrorCode::FileFormat);
  EXPECT_EQ(
      codeOf("a.mhd",
             "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
             "ElementDataFile = a.raw\n"),
      ErrorCode::FileFormat);
  NiftiBytes pair(2, 2, 2);
  pair.set<float>(108, 0).set<std::int32_t>(344, 0x0031696e); // "ni1"
  EXPECT_EQ(codeOf("a.hdr", pair.with("")), ErrorCode::FileNotFound);
  writeBytes(folder / "a.img", "12345678");
  EXPECT_EQ(readVolume(folder / "a.hdr").voxels,
            (std::vector<float>{'1', '2', '3', '4', '5', '6', '7', '8'}));
  EXPECT_EQ(readVolume(folder / "a.img").voxels.back(), '8');
}

TEST_F(BadImage, RealOnes) {
  INNERGS_NEED("G_shear_sform.nii.gz");
  EXPECT_EQ(codeOf(dataFile("G_shear_sform.nii.gz")), ErrorCode::Geometry);
  EXPECT_EQ(codeOf(dataFile("G_rgb24_ct_perfusion.nii.gz")), ErrorCode::UnsupportedImage);
  EXPECT_EQ(codeOf(dataFile("G_oblique_4d_TR2000.nii.gz")), ErrorCode::UnsupportedImage);
}

} // namespace
} // namespace innergs::test
