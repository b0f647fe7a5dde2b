#include "Core/Base/NumberText.h"
#include "IO/ImageReading.h"
#include "IO/TrackedSweep.h"
#include "IO/VolumeIO.h"
#include "SyntheticDicom.h"
#include "TestFiles.h"

#include <algorithm>
#include <cmath>

namespace innergs::test {
namespace {

constexpr const char* sweep = "F_tracked_us_SpinePhantomFreehand.igs.mha";

/// Writes slices at these origins, with values 100, 101, ...
void writeSlices(const TemporaryFolder& folder, const std::vector<Vec3>& origins) {
  std::map<std::string, std::string> tags{
      {"0020|000d", "1.2.3"}, {"0020|000e", "1.2.3.4"}, {"0020|0011", "4"}};
  for (std::size_t k = 0; k < origins.size(); ++k) {
    tags["0008|0018"] = "1.2.3.4." + std::to_string(k + 1);
    tags["0020|0013"] = std::to_string(k + 1);
    writeDicomSlice(folder / (std::to_string(k) + ".dcm"), origins[k], {}, 100 + static_cast<int>(k), tags);
  }
}

std::vector<Vec3> along(const std::vector<double>& heights) {
  std::vector<Vec3> origins;
  for (const double z : heights)
    origins.push_back({0, 0, z});
  return origins;
}

Vec3 placeOf(const Stack& stack, const Vec3& index) {
  const Vec3 x = stack.image.geometry.indexToWorld()(index);
  return stack.poses.empty() ? x : stack.poses[static_cast<std::size_t>(index[2])](x);
}

bool saysAny(const std::vector<std::string>& remarks, const std::string& text) {
  return std::any_of(remarks.begin(), remarks.end(),
                     [&](const std::string& r) { return r.find(text) != std::string::npos; });
}

TEST(PosedDicom, TiltedGantryKeepsEverySliceWhereItLies) {
  const TemporaryFolder folder;
  std::vector<Vec3> origins;
  for (int k = 0; k < 5; ++k)
    origins.push_back({-20, 10 + 1.2 * k, 4.0 * k});
  writeSlices(folder, origins);
  const Stack stack = readStack(folder.path());
  EXPECT_NO_THROW(checkStack(stack));
  ASSERT_EQ(stack.poses.size(), 5U);
  EXPECT_NEAR(stack.image.geometry.spacing[2], 4, 1e-6);
  EXPECT_NEAR(column(stack.image.geometry.direction, 2)[2], 1, 1e-9);
  for (int k = 0; k < 5; ++k) {
    EXPECT_LT(norm(placeOf(stack, {0, 0, double(k)}) - origins[k]), 1e-6);
    EXPECT_LT(norm(placeOf(stack, {2, 3, double(k)}) - (origins[k] + Vec3{2, 3, 0})), 1e-6);
    EXPECT_EQ(stack.image.voxels[static_cast<std::size_t>(30 * k)], 100 + k);
  }
  EXPECT_TRUE(saysAny(stack.remarks, "up to 4.8 mm"));
  EXPECT_EQ(errorOf([&] { readVolume(folder.path()); }).code(), ErrorCode::Geometry);
}

TEST(PosedDicom, UnevenSlicesKeepTheirPlaces) {
  for (const auto& heights : {std::vector<double>{0, 3, 6, 9, 13.5, 18, 22.5},  // two distances
                              std::vector<double>{0, 5, 10, 15, 25, 35, 45}}) { // twice as far above
    const TemporaryFolder folder;
    writeSlices(folder, along(heights));
    const Stack stack = readStack(folder.path());
    EXPECT_NO_THROW(checkStack(stack));
    ASSERT_EQ(stack.poses.size(), heights.size());
    for (std::size_t k = 0; k < heights.size(); ++k)
      EXPECT_LT(norm(placeOf(stack, {0, 0, double(k)}) - Vec3{0, 0, heights[k]}), 1e-6);
    EXPECT_TRUE(saysAny(stack.remarks, "mm apart"));
  }
}

TEST(PosedDicom, EvenSlicesHaveNoPoses) {
  const TemporaryFolder folder;
  writeSlices(folder, along({0, 3, 6.01, 9}));
  const Stack stack = readStack(folder.path());
  EXPECT_TRUE(stack.poses.empty());
  EXPECT_TRUE(stack.remarks.empty());
}

TEST(PosedDicom, WhatLooksIncompleteOrRepeatedIsRefused) {
  for (const auto& heights : {std::vector<double>{0, 3, 6, 12, 15, 18}, std::vector<double>{0, 3, 12, 15}}) {
    const TemporaryFolder folder;
    writeSlices(folder, along(heights));
    const Error error = errorOf([&] { readStack(folder.path()); });
    EXPECT_EQ(error.code(), ErrorCode::Geometry);
    EXPECT_TRUE(contains(error, "missing")) << error.what();
  }
  const TemporaryFolder folder;
  writeSlices(folder, along({0, 3, 3, 6}));
  EXPECT_EQ(errorOf([&] { readStack(folder.path()); }).code(), ErrorCode::UnsupportedImage);
}

std::string matrixText(const Affine3& a) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    text += formatted("%.9g %.9g %.9g %.9g ", a.linear[row][0], a.linear[row][1], a.linear[row][2],
                      a.offset[row]);
  return text + "0 0 0 1";
}

Affine3 turn(double angle, const Vec3& shift) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {{{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}}, shift};
}

/// Four images of 4 x 3 pixels: calibration, the probe's and the reference's places in the tracker's system.
struct Sweep {
  Affine3 calibration{diagonal({0.5, 0.4, 0.45}), {1, 2, 3}};
  Affine3 reference = turn(0.7, {10, -20, 5});
  std::vector<Affine3> probes{turn(0, {0, 0, 0}), turn(0.02, {0.1, 0, 1.5}), turn(0.05, {0, 0.2, 3}),
                              turn(0.03, {0, 0, 4.4})};
  std::string more; // further fields
  bool inFile = true;

  void write(const std::filesystem::path& path) const {
    std::string header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 4 3 4\n"
                         "ElementType = MET_UCHAR\n";
    for (std::size_t k = 0; k < probes.size(); ++k) {
      const std::string frame = formatted("Seq_Frame%04d_", static_cast<int>(k));
      header += frame + "ProbeToTrackerTransform = " + matrixText(probes[k]) + "\n";
      header += frame + "ReferenceToTrackerTransform = " + matrixText(reference) + "\n";
      if (inFile) header += frame + "ImageToProbeTransform = " + matrixText(calibration) + "\n";
    }
    std::string voxels;
    for (int v = 0; v < 48; ++v)
      voxels += static_cast<char>(v);
    writeBytes(path, header + more + "ElementDataFile = LOCAL\n" + voxels);
  }
  Vec3 place(int i, int j, std::size_t k) const { // LPS
    const Vec3 x = (inverse(reference) * probes[k] * calibration)({double(i), double(j), 0});
    return {-x[0], -x[1], x[2]};
  }
};

TEST(TrackedSweep, EveryPixelLiesWhereTheTransformsPutIt) {
  const TemporaryFolder folder;
  const Sweep given;
  given.write(folder / "a.igs.mha");
  const Stack stack = readStack(folder / "a.igs.mha");
  EXPECT_NO_THROW(checkStack(stack));
  ASSERT_EQ(stack.poses.size(), 4U);
  EXPECT_NEAR(stack.image.geometry.spacing[0], 0.5, 1e-6);
  EXPECT_NEAR(stack.image.geometry.spacing[1], 0.4, 1e-6);
  EXPECT_NEAR(stack.image.geometry.spacing[2], 1.5, 0.1);
  EXPECT_EQ(stack.thickness, 1);
  for (std::size_t k = 0; k < 4; ++k)
    for (const auto& [i, j] : {std::pair(0, 0), std::pair(3, 0), std::pair(3, 2)}) {
      EXPECT_LT(norm(placeOf(stack, {double(i), double(j), double(k)}) - given.place(i, j, k)), 1e-5);
      EXPECT_EQ(stack.image.voxels[static_cast<std::size_t>(i + 4 * j) + 12 * k],
                float(i + 4 * j + 12 * int(k)));
    }
  EXPECT_TRUE(stack.remarks.empty());
}

TEST(TrackedSweep, InvalidImagesAreLeftOut) {
  const TemporaryFolder folder;
  Sweep given;
  given.more = "Seq_Frame0001_ProbeToTrackerTransformStatus = INVALID\n"
               "Seq_Frame0002_StylusToTrackerTransform = none\n"
               "Seq_Frame0002_StylusToTrackerTransformStatus = INVALID\n";
  given.write(folder / "a.mha");
  const Stack stack = readStack(folder / "a.mha");
  ASSERT_EQ(stack.poses.size(), 3U);
  EXPECT_LT(norm(placeOf(stack, {1, 1, 1}) - given.place(1, 1, 2)), 1e-5);
  EXPECT_EQ(stack.image.voxels[12], 24);
  EXPECT_TRUE(saysAny(stack.remarks, "1 image of 4"));
}

TEST(TrackedSweep, OrientationTurnsThePixels) {
  const TemporaryFolder folder;
  Sweep given;
  given.more = "UltrasoundImageOrientation = UNA\n";
  given.write(folder / "a.mha");
  EXPECT_EQ(readStack(folder / "a.mha").image.voxels.front(), 11);
  given.more = "UltrasoundImageOrientation = FMA\n";
  given.write(folder / "a.mha");
  EXPECT_EQ(errorOf([&] { readStack(folder / "a.mha"); }).code(), ErrorCode::UnsupportedImage);
}

TEST(TrackedSweep, CalibrationComesFromAFile) {
  const TemporaryFolder folder;
  Sweep given;
  given.inFile = false;
  given.write(folder / "a.mha");
  const Error none = errorOf([&] { readStack(folder / "a.mha"); });
  EXPECT_EQ(none.code(), ErrorCode::UnsupportedImage);
  EXPECT_TRUE(contains(none, "ImageToProbe")) << none.what();
  const std::string matrix = matrixText(given.calibration);
  writeBytes(folder / "c.xml", "<PlusConfiguration version=\"2.1\"><CoordinateDefinitions>\n"
                               "<!-- <Transform From=\"Image\" To=\"Probe\" Matrix=\"1\"/> -->\n"
                               "<Transform From=\"Image\" To=\"Probe\" Matrix=\"" +
                                   matrix + "\"/></CoordinateDefinitions></PlusConfiguration>\n");
  writeBytes(folder / "c.txt", matrix + "\n");
  for (const char* file : {"c.xml", "c.txt"}) {
    ReadOptions options;
    options.calibration = folder / file;
    const Stack stack = readStack(folder / "a.mha", options);
    EXPECT_LT(norm(placeOf(stack, {3, 2, 2}) - given.place(3, 2, 2)), 1e-5) << file;
  }
  for (const char* text : {"1 2 3", "<PlusConfiguration>", "<PlusConfiguration/>",
                           "<C><Transform From=\"Image\" To=\"Probe\" Matrix=\"1 nan\"/></C>"}) {
    writeBytes(folder / "bad.xml", text);
    EXPECT_EQ(errorOf([&] { readCalibration(folder / "bad.xml"); }).code(), ErrorCode::FileFormat) << text;
  }
}

TEST(TrackedSweep, ShearedImagesAreResampled) {
  const TemporaryFolder folder;
  Sweep given;
  given.calibration = {Mat3{{{{0.5, 0.05, 0}, {0, 0.4, 0}, {0, 0, 0.45}}}}, {1, 2, 3}};
  given.write(folder / "a.mha");
  const Stack stack = readStack(folder / "a.mha");
  EXPECT_NO_THROW(checkStack(stack));
  EXPECT_TRUE(saysAny(stack.remarks, "83 degrees") || saysAny(stack.remarks, "82.9 degrees"));
  EXPECT_EQ(stack.image.geometry.size[0], 5);
  // Row 2 lies 0.2 pixels further along: the first pixel there is not seen, the second is between two.
  EXPECT_EQ(stack.observed[10], 0);
  EXPECT_NEAR(stack.image.voxels[11], 8.8, 1e-4);
  EXPECT_LT(norm(placeOf(stack, {1.2, 2, 3}) - given.place(1, 2, 3)), 1e-5);
  given.calibration.linear[0][1] = 0.3;
  given.write(folder / "a.mha");
  EXPECT_EQ(errorOf([&] { readStack(folder / "a.mha"); }).code(), ErrorCode::Geometry);
}

TEST(TrackedSweep, TransformsThatScaleOrStandStillAreRefused) {
  const TemporaryFolder folder;
  Sweep given;
  given.probes[2].linear = diagonal({1, 1.1, 1});
  given.write(folder / "a.mha");
  const Error scaled = errorOf([&] { readStack(folder / "a.mha"); });
  EXPECT_EQ(scaled.code(), ErrorCode::Geometry);
  EXPECT_TRUE(contains(scaled, "not rigid")) << scaled.what();
  given.probes.assign(4, {});
  given.write(folder / "a.mha");
  EXPECT_TRUE(contains(errorOf([&] { readStack(folder / "a.mha"); }), "in one place"));
}

TEST(TrackedSweep, RealSweepFromItsCalibration) {
  INNERGS_NEED(sweep);
  const TemporaryFolder folder;
  // From IGSIO's test configuration of this sweep.
  writeBytes(folder / "c.txt", "-0.00157821 0.0785919 -0.00803285 15.3978 -0.0839128 0.00372697 0.0153803 "
                               "49.5705 0.0159024 0.00714276 0.0803604 -8.63446 0 0 0 1");
  ReadOptions options;
  options.calibration = folder / "c.txt";
  const Stack stack = readStack(dataFile(sweep), options);
  EXPECT_NO_THROW(checkStack(stack));
  EXPECT_EQ(stack.poses.size(), 21U);
  EXPECT_NEAR(stack.image.geometry.spacing[0], 0.1708, 1e-3);
  EXPECT_NEAR(stack.image.geometry.spacing[2], 1.63, 0.02);
}

} // namespace
} // namespace innergs::test
