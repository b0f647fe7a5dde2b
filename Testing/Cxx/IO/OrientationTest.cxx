#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <algorithm>

namespace innergs::test {
namespace {

const char* const volumeFiles[] = {"volume.nii", "volume.nii.gz", "volume.nrrd", "volume.mha"};

void expectSameGeometry(const GridGeometry& read, const GridGeometry& written) {
  EXPECT_EQ(read.size, written.size);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(read.origin[i], written.origin[i], 1e-4);
    EXPECT_NEAR(read.spacing[i], written.spacing[i], 1e-6);
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(read.direction[i][j], written.direction[i][j], 1e-6);
  }
}

/// Writes a landmark, reads it, and looks it up in patient space.
void roundTrip(const Mat3& direction, const TemporaryFolder& folder) {
  GridGeometry geometry{{14, 11, 9}, {-31.5, 47.25, 1000.125}, {1.1, 0.9, 1.7}, direction};
  const Vec3 landmark = geometry.indexToWorld()({6.3, 5.4, 4.2});
  const Volume volume = blob(geometry, landmark, 1.2);
  const Vec3 marked = centreOfMass(volume);
  for (const char* format : volumeFiles) {
    SCOPED_TRACE(format);
    writeVolume(volume, folder / format);
    const Volume read = readVolume(folder / format);
    expectSameGeometry(read.geometry, geometry);
    EXPECT_EQ(read.voxels, volume.voxels);
    EXPECT_LT(norm(centreOfMass(read) - marked), 0.05 * 0.9);
  }
}

TEST(Orientation, All48AxisCodes) {
  const TemporaryFolder folder;
  std::array<int, 3> order{0, 1, 2};
  int codes = 0, leftHanded = 0;
  do {
    for (int signs = 0; signs < 8; ++signs, ++codes) {
      Mat3 direction;
      direction.m = {};
      for (int axis = 0; axis < 3; ++axis)
        direction[order[axis]][axis] = signs >> axis & 1 ? -1 : 1;
      leftHanded += determinant(direction) < 0;
      SCOPED_TRACE("code " + std::to_string(codes));
      roundTrip(direction, folder);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(codes, 48);
  EXPECT_EQ(leftHanded, 24);
}

Mat3 rotation(double a, double b, double c) {
  const Mat3 x{{{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}}};
  const Mat3 y{{{{std::cos(b), 0, std::sin(b)}, {0, 1, 0}, {-std::sin(b), 0, std::cos(b)}}}};
  const Mat3 z{{{{std::cos(c), -std::sin(c), 0}, {std::sin(c), std::cos(c), 0}, {0, 0, 1}}}};
  return z * y * x;
}

TEST(Orientation, ObliqueAndLeftHanded) {
  const TemporaryFolder folder;
  for (const double angle : {0.01, 0.3, 1.2, 2.9}) {
    const Mat3 oblique = rotation(angle, 0.7 * angle, -1.3 * angle);
    SCOPED_TRACE(angle);
    roundTrip(oblique, folder);
    roundTrip(oblique * diagonal({1, 1, -1}), folder);
    roundTrip(oblique * diagonal({-1, 1, 1}), folder);
  }
}

// Reading and writing could be wrong in the same way, so this checks the bytes.
TEST(Orientation, HeadersSayWhatTheFormatsDefine) {
  const TemporaryFolder folder;
  const Mat3 direction{
      {{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}}}; // I to posterior, J to superior, K to right (LPS)
  const Volume volume = blob({{4, 5, 6}, {10, 20, 30}, {1, 2, 3}, direction}, {10, 20, 30}, 2);
  for (const char* format : {"a.nii", "a.nrrd", "a.mha"})
    writeVolume(volume, folder / format);

  const std::string nifti = readBytes(folder / "a.nii");
  const auto at = [&](int offset) {
    float value;
    std::memcpy(&value, nifti.data() + offset, 4);
    return value;
  };
  const float sform[3][4] = {{0, 0, 3, -10}, {-1, 0, 0, -20}, {0, 2, 0, 30}}; // RAS
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_EQ(at(280 + 16 * row + 4 * column), sform[row][column]);

  const std::string nrrd = readBytes(folder / "a.nrrd");
  EXPECT_NE(nrrd.find("space: left-posterior-superior"), std::string::npos);
  EXPECT_NE(nrrd.find("space directions: (0,1,0) (0,0,2) (-3,0,0)"), std::string::npos)
      << nrrd.substr(0, 500);
  EXPECT_NE(nrrd.find("space origin: (10,20,30)"), std::string::npos);
  const std::string meta = readBytes(folder / "a.mha");
  EXPECT_NE(meta.find("TransformMatrix = 0 1 0 0 0 1 -1 0 0"), std::string::npos) << meta.substr(0, 500);
  EXPECT_NE(meta.find("Offset = 10 20 30"), std::string::npos);
}

TEST(Orientation, OneHeadInSixOrientations) {
  INNERGS_NEED("G_orient_RAS.nii.gz");
  const Volume reference = readVolume(dataFile("G_orient_RAS.nii.gz"));
  expectSameGeometry(reference.geometry, {{64, 79, 67},
                                          {75.76253509521484, 110.762516021728516, -71.76253509521484},
                                          reference.geometry.spacing,
                                          {{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}}});
  const Affine3 toReference = inverse(reference.geometry.indexToWorld());
  for (const char* name : {"LPS", "AIL", "PSR", "SLA", "IRP"}) {
    SCOPED_TRACE(name);
    const Volume head = readVolume(dataFile("G_orient_" + std::string(name) + ".nii.gz"));
    const Affine3 toIndex = inverse(head.geometry.indexToWorld());
    EXPECT_LT(norm(centreOfMass(head) - centreOfMass(reference)), 0.05 * 2.36);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> inside(10, 50);
    for (int n = 0; n < 200; ++n) {
      const Vec3 world = reference.geometry.indexToWorld()({inside(random), inside(random), inside(random)});
      EXPECT_NEAR(sampleLinear(head, toIndex(world)), sampleLinear(reference, toReference(world)), 0.02);
    }
  }
}

TEST(Orientation, RealFilesThroughEveryFormat) {
  INNERGS_NEED("B_wrist01_LAVA_static.nii.gz");
  const TemporaryFolder folder;
  for (const char* name : {"B_wrist01_LAVA_static.nii.gz", "G_mha_64x64x37.mha", "G_detached.nhdr"}) {
    const Volume volume = readVolume(dataFile(name));
    for (const char* format : {"volume.nii", "volume.nrrd", "volume.mha"}) {
      SCOPED_TRACE(std::string(name) + " as " + format);
      writeVolume(volume, folder / format, OutputType::Int16);
      const Volume read = readVolume(folder / format);
      expectSameGeometry(read.geometry, volume.geometry);
      EXPECT_EQ(read.voxels, volume.voxels);
    }
  }
}

// The same acquisition as NIfTI and, labelled in Slicer, as NRRD.
TEST(Orientation, TwoProgramsAgree) {
  INNERGS_NEED("B_wrist01_LAVA_static.seg.nrrd");
  const Volume image = readVolume(dataFile("B_wrist01_LAVA_static.nii.gz"));
  const Mask mask = readMask(dataFile("B_wrist01_LAVA_static.seg.nrrd"));
  EXPECT_TRUE(sameGrid(image.geometry, mask.geometry, 0.02));
}

} // namespace
} // namespace innergs::test
