#include "IO/ImageReading.h"
#include "TestFiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace innergs::test {
namespace {

ReadOptions frame(int n) {
  return {n};
}

TEST(ImageReading, IRunsFastest) {
  const TemporaryFolder folder;
  std::string voxels(24, '\0');
  for (int n = 0; n < 24; ++n)
    voxels[static_cast<std::size_t>(n)] = static_cast<char>(n);
  writeBytes(folder / "a.nii", NiftiBytes(4, 3, 2).with(voxels));
  writeBytes(folder / "a.mha",
             "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             "DimSize = 4 3 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                 voxels);
  writeBytes(folder / "a.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\n" + voxels);
  for (const char* name : {"a.nii", "a.mha", "a.nrrd"}) {
    const Volume volume = readVolume(folder / name);
    EXPECT_EQ(volume.geometry.size, (std::array<std::int64_t, 3>{4, 3, 2})) << name;
    for (int n = 0; n < 24; ++n)
      EXPECT_EQ(volume.voxels[static_cast<std::size_t>(n)], n) << name;
  }
}

TEST(ImageReading, FramesOfFourDimensionalFiles) {
  const TemporaryFolder folder;
  std::string voxels;
  for (int n = 0; n < 3 * 8; ++n)
    voxels += static_cast<char>(n);
  writeBytes(folder / "a.nii",
             NiftiBytes(2, 2, 2).set<std::int16_t>(40, 4).set<std::int16_t>(48, 3).with(voxels));
  writeBytes(folder / "a.mha",
             "ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             "DimSize = 2 2 2 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                 voxels);
  // A sequence as written by 3D Slicer: the frames of a voxel are adjacent.
  std::string interleaved;
  for (int n = 0; n < 8; ++n)
    for (int f = 0; f < 3; ++f)
      interleaved += static_cast<char>(8 * f + n);
  writeBytes(folder / "a.seq.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 4\nspace: left-posterior-superior\nsizes: 3 2 2 2\n"
             "space directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: list domain domain domain\n"
             "space origin: (0,0,0)\nencoding: raw\n\n" +
                 interleaved);
  for (const char* name : {"a.nii", "a.mha", "a.seq.nrrd"}) {
    SCOPED_TRACE(name);
    const Error refused = errorOf([&] { readVolume(folder / name); });
    EXPECT_EQ(refused.code(), ErrorCode::UnsupportedImage);
    EXPECT_TRUE(contains(refused, "3 frames") && contains(refused, "choose a frame (0 to 2)"))
        << refused.what();
    for (int f = 0; f < 3; ++f) {
      const Volume volume = readVolume(folder / name, frame(f));
      EXPECT_EQ(volume.geometry.size, (std::array<std::int64_t, 3>{2, 2, 2}));
      for (int n = 0; n < 8; ++n)
        EXPECT_EQ(volume.voxels.at(static_cast<std::size_t>(n)), 8 * f + n);
    }
    EXPECT_EQ(errorOf([&] { readVolume(folder / name, frame(3)); }).code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(errorOf([&] { readVolume(folder / name, frame(-1)); }).code(), ErrorCode::InvalidArgument);
  }
}

TEST(ImageReading, FrameOfAThreeDimensionalFile) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.nii", NiftiBytes(2, 2, 2).with(std::string(8, '\1')));
  EXPECT_EQ(readVolume(folder / "a.nii", frame(0)).voxels.size(), 8u);
  EXPECT_EQ(errorOf([&] { readVolume(folder / "a.nii", frame(1)); }).code(), ErrorCode::InvalidArgument);
}

TEST(ImageReading, NiftiScalingAndTypes) {
  const TemporaryFolder folder;
  const auto read = [&](NiftiBytes header, std::int16_t code, std::int16_t bits, const std::string& voxels) {
    writeBytes(folder / "a.nii", header.type(code, bits).with(voxels));
    return readVolume(folder / "a.nii").voxels;
  };
  NiftiBytes scaled(2, 1, 2);
  scaled.set<float>(112, 0.5f).set<float>(116, -1024.f);
  EXPECT_EQ(read(scaled, 4, 16, rawBytes<std::int16_t>({-2, 0, 7, 32767})),
            (std::vector<float>{-1025, -1024, -1020.5f, 15359.5f}));
  EXPECT_EQ(read(scaled, 16, 32, rawBytes<float>({2, 4, 6, 8})),
            (std::vector<float>{-1023, -1022, -1021, -1020}));
  const NiftiBytes plain(2, 1, 2);
  EXPECT_EQ(read(plain, 256, 8, rawBytes<std::int8_t>({-128, -1, 0, 127})),
            (std::vector<float>{-128, -1, 0, 127}));
  EXPECT_EQ(read(plain, 512, 16, rawBytes<std::uint16_t>({0, 1, 2, 65535})),
            (std::vector<float>{0, 1, 2, 65535}));
  EXPECT_EQ(read(plain, 8, 32, rawBytes<std::int32_t>({-70000, 0, 1, 70000})),
            (std::vector<float>{-70000, 0, 1, 70000}));
  EXPECT_EQ(read(plain, 768, 32, rawBytes<std::uint32_t>({0, 1, 2, 4294967040u})),
            (std::vector<float>{0, 1, 2, 4294967040.f}));
  EXPECT_EQ(read(plain, 64, 64, rawBytes<double>({1e-6, 2.5e-6, -3, 0})),
            (std::vector<float>{1e-6f, 2.5e-6f, -3, 0}));
}

TEST(ImageReading, NonFiniteVoxelsStay) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const Volume volume{{{2, 2, 2}, {0, 0, 0}, {1, 1, 1}, {}}, {0, nan, inf, -inf, 1, nan, 2, 3}};
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    writeVolume(volume, folder / name);
    const std::vector<float> read = readVolume(folder / name).voxels;
    for (std::size_t n = 0; n < 8; ++n)
      EXPECT_EQ(std::bit_cast<std::uint32_t>(read.at(n)), std::bit_cast<std::uint32_t>(volume.voxels[n]))
          << name << " " << n;
  }
}

TEST(ImageReading, UnitsOfNifti) {
  const TemporaryFolder folder;
  const std::pair<char, double> units[] = {{3, 1e-3}, {1, 1e3}, {2, 1}, {0, 1}};
  for (const auto& [code, millimetres] : units) {
    NiftiBytes header(2, 2, 2);
    header.set<char>(123, code);
    for (int axis = 0; axis < 3; ++axis)
      header.set<float>(80 + 4 * axis, 500)
          .set<float>(280 + 20 * axis, 500)
          .set<float>(292 + 16 * axis, 2000);
    writeBytes(folder / "a.nii", header.with(std::string(8, '\1')));
    const GridGeometry geometry = readVolume(folder / "a.nii").geometry;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(geometry.spacing[axis], 500 * millimetres, 1e-6 * 500 * millimetres);
      EXPECT_NEAR(geometry.origin[axis], (axis < 2 ? -2000 : 2000) * millimetres, 1e-6 * 2000 * millimetres);
    }
  }
}

TEST(ImageReading, RealMicronMillisecondSeries) {
  INNERGS_NEED("G_4d_units_micron_msec.nii.gz");
  const Error refused = errorOf([] { readVolume(dataFile("G_4d_units_micron_msec.nii.gz")); });
  EXPECT_EQ(refused.code(), ErrorCode::UnsupportedImage);
  EXPECT_TRUE(contains(refused, "7 frames")) << refused.what();
  const GridGeometry geometry = readVolume(dataFile("G_4d_units_micron_msec.nii.gz"), frame(6)).geometry;
  EXPECT_EQ(geometry.size, (std::array<std::int64_t, 3>{40, 42, 5}));
  EXPECT_NEAR(geometry.spacing[0], 0.841346, 1e-5);
  EXPECT_NEAR(geometry.spacing[2], 17.5, 1e-4);
  EXPECT_NEAR(geometry.origin[0], -9.0353955, 1e-5);
  EXPECT_NEAR(geometry.origin[1], 17.2721113, 1e-5);
  EXPECT_NEAR(geometry.origin[2], -26.1166191, 1e-5);
}

TEST(ImageReading, RealMincSeries) {
  INNERGS_NEED("G_minc2_4d.mnc");
  EXPECT_EQ(errorOf([] { readVolume(dataFile("G_minc2_4d.mnc")); }).code(), ErrorCode::UnsupportedImage);
  float low = 1e9f, high = -1e9f;
  for (int n = 0; n < 2; ++n) {
    const Volume volume = readVolume(dataFile("G_minc2_4d.mnc"), frame(n));
    EXPECT_EQ(volume.geometry.size, (std::array<std::int64_t, 3>{20, 20, 10}));
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_DOUBLE_EQ(volume.geometry.spacing[axis], 2);
    // RAS start -20 -20 -10, in LPS
    EXPECT_NEAR(norm(volume.geometry.origin - Vec3{20, 20, -10}), 0, 1e-9);
    EXPECT_EQ(volume.geometry.direction, diagonal({-1, -1, 1}));
    low = std::min(low, *std::min_element(volume.voxels.begin(), volume.voxels.end()));
    high = std::max(high, *std::max_element(volume.voxels.begin(), volume.voxels.end()));
  }
  EXPECT_NEAR(low, 0.207843, 1e-5);
  EXPECT_NEAR(high, 1.49804, 1e-5);
}

TEST(ImageReading, RealByteOrderTypesAndNonFinite) {
  INNERGS_NEED("B_abdomen_spgr_FA15.nii.gz");
  const Volume plain = readVolume(dataFile("B_abdomen_spgr_FA15.nii.gz"));
  const Volume big = readVolume(dataFile("G_bigendian_int16.nii"));
  const Volume tiny = readVolume(dataFile("G_float64_tiny_values.nii.gz"));
  const Volume nan = readVolume(dataFile("G_nan_inf_float32.nii.gz"));
  EXPECT_TRUE(sameGrid(plain.geometry, big.geometry));
  std::int64_t nonFinite = 0;
  for (std::size_t n = 0; n < plain.voxels.size(); ++n) {
    ASSERT_NEAR(big.voxels[n], plain.voxels[n], 0.5);
    ASSERT_NEAR(tiny.voxels[n], 1e-6 * plain.voxels[n], 1e-9);
    nonFinite += !std::isfinite(nan.voxels[n]);
  }
  EXPECT_EQ(nonFinite, 34562);
}

TEST(ImageReading, StackTakesTheCoarsestAxisAsSlices) {
  const TemporaryFolder folder;
  for (int axis = 0; axis < 3; ++axis) {
    GridGeometry geometry{{7, 6, 5}, {3, -2, 11}, {1, 1, 1}, {{{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}}}};
    geometry.spacing[axis] = 4;
    const Volume volume = blob(geometry, geometry.centre() + Vec3{0.4, -0.3, 0.2}, 3);
    writeVolume(volume, folder / "a.nrrd");
    const Stack stack = readStack(folder / "a.nrrd");
    EXPECT_EQ(stack.image.geometry.spacing, (Vec3{1, 1, 4}));
    EXPECT_EQ(stack.image.geometry.size[2], geometry.size[axis]);
    EXPECT_LT(norm(centreOfMass(stack.image) - centreOfMass(volume)), 1e-6);
    EXPECT_EQ(stack.name, "a.nrrd");
    EXPECT_EQ(stack.thickness, 0);
    EXPECT_EQ(stack.profile, SliceProfile::Box);
  }
}

TEST(ImageReading, StackKeepsKWhenNothingIsClearlyCoarser) {
  const TemporaryFolder folder;
  for (const Vec3& spacing : {Vec3{1.1, 1, 1}, Vec3{2, 2, 1}, Vec3{1, 1, 1}}) {
    writeVolume(blob({{7, 6, 5}, {0, 0, 0}, spacing, {}}, {3, 3, 3}, 3), folder / "a.nrrd");
    EXPECT_EQ(readStack(folder / "a.nrrd").image.geometry.spacing, spacing);
  }
}

std::string rawNrrd(const std::string& fields) {
  return "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 5\n"
         "space directions: (1,0,0) (0,1,0) (0,0,4)\nspace origin: (0,0,0)\nencoding: raw\n" +
         fields + "\n" + std::string(60, '\1');
}

TEST(ImageReading, ThicknessOfNrrd) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& fields) {
    writeBytes(folder / "a.nrrd", rawNrrd(fields));
    return readStack(folder / "a.nrrd");
  };
  EXPECT_DOUBLE_EQ(read("thicknesses: NaN NaN 3.25\n").thickness, 3.25);
  EXPECT_EQ(read("thicknesses: NaN NaN 3.25\n").thicknessFrom, "NRRD thicknesses");
  for (const char* unknown : {"", "thicknesses: NaN NaN NaN\n", "thicknesses: 3 3 nan\n"}) {
    EXPECT_EQ(read(unknown).thickness, 0) << unknown;
    EXPECT_EQ(read(unknown).thicknessFrom, "") << unknown;
  }
  writeBytes(folder / "a.seq.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 3 5 4\n"
             "space directions: none (1,0,0) (0,4,0) (0,0,1)\nkinds: list domain domain domain\n"
             "thicknesses: NaN NaN 5 NaN\nspace origin: (0,0,0)\nencoding: raw\n\n" +
                 std::string(120, '\1'));
  const Stack stack = readStack(folder / "a.seq.nrrd", frame(1));
  EXPECT_EQ(stack.image.geometry.size[2], 5);
  EXPECT_DOUBLE_EQ(stack.thickness, 5) << "of the axis that counts the slices";
}

TEST(ImageReading, ThicknessOfMetaImage) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& fields) {
    writeBytes(folder / "a.mha",
               "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
               "DimSize = 4 3 5\nElementSpacing = 0.8 0.8 4\n" +
                   fields + "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + std::string(60, '\1'));
    const Stack stack = readStack(folder / "a.mha");
    EXPECT_DOUBLE_EQ(stack.image.geometry.spacing[2], 4);
    EXPECT_EQ(stack.thicknessFrom, stack.thickness > 0 ? "MetaImage ElementSize" : "");
    return stack.thickness;
  };
  EXPECT_DOUBLE_EQ(read("ElementSize = 0.8 0.8 5.5\n"), 5.5);
  EXPECT_EQ(read(""), 0);
  EXPECT_EQ(read("ElementSize = 0.8 0.8 4\n"), 0);
  EXPECT_EQ(read("ElementSize = 1 1 1\n"), 0) << "a writer's default";
}

// The slices of NiftiBytes(4, 3, 6), 4 mm apart along K.
NiftiBytes thickNifti() {
  return NiftiBytes(4, 3, 6).set<float>(88, 4).set<float>(320, 4);
}

TEST(ImageReading, SlicesAsBidsSays) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.nii", thickNifti().with(std::string(72, '\1')));
  const auto read = [&](const std::string& sidecar) {
    writeBytes(folder / "a.json", sidecar);
    return readStack(folder / "a.nii");
  };
  const std::string timing = R"("SliceTiming": [0, 3, 1, 4, 2, 5])";
  const Stack stack = read(R"({"SliceThickness": 3.5, )" + timing + "}");
  EXPECT_DOUBLE_EQ(stack.thickness, 3.5);
  EXPECT_EQ(stack.thicknessFrom, "SliceThickness in 'a.json'");
  EXPECT_EQ(stack.times, (std::vector<double>{0, 3, 1, 4, 2, 5}));
  EXPECT_EQ(read(R"({"SliceEncodingDirection": "k-", )" + timing + "}").times,
            (std::vector<double>{5, 2, 4, 1, 3, 0}));
  // What is said of other slices, or is no such value, is no reason to refuse a still image.
  for (const char* other :
       {R"({"SliceEncodingDirection": "j", "SliceThickness": 3.5, "SliceTiming": [0, 2, 1]})",
        R"({"SliceThickness": "thin", "SliceTiming": [0, 1]})", R"({"SliceThickness": -1})",
        R"({"SliceEncodingDirection": 3, "SliceThickness": 3.5})", R"([1, 2])", R"({"SliceTiming": [)",
        R"({"SliceTiming": [0, 1, 2, "3", 4, 5]})", R"({"SliceTiming": [1, 1, 1, 1, 1, 1]})"}) {
    EXPECT_EQ(read(other).thickness, 0) << other;
    EXPECT_TRUE(read(other).times.empty()) << other;
  }
}

TEST(ImageReading, SlicesAlongAnotherAxisAsBidsSays) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.nii",
             NiftiBytes(4, 6, 3).set<float>(84, 4).set<float>(300, 4).with(std::string(72, '\1')));
  writeBytes(folder / "a.json", R"({"SliceEncodingDirection": "j", "SliceThickness": 3.5,
                                    "SliceTiming": [0, 3, 1, 4, 2, 5]})");
  const Stack stack = readStack(folder / "a.nii");
  EXPECT_EQ(stack.image.geometry.size[2], 6);
  EXPECT_DOUBLE_EQ(stack.thickness, 3.5);
  EXPECT_EQ(stack.times, (std::vector<double>{0, 3, 1, 4, 2, 5}));
}

TEST(ImageReading, SliceOrderOfNifti) {
  const TemporaryFolder folder;
  const auto times = [&](char code, float duration) {
    NiftiBytes header = thickNifti();
    header.set<char>(39, 3 << 4).set<char>(122, code).set<float>(132, duration).set<std::int16_t>(120, 5);
    writeBytes(folder / "a.nii", header.with(std::string(72, '\1')));
    return readStack(folder / "a.nii").times;
  };
  EXPECT_EQ(times(3, 0.5f), (std::vector<double>{0, 1.5, 0.5, 2, 1, 2.5}));
  EXPECT_TRUE(times(0, 0.5f).empty());
  EXPECT_TRUE(times(3, 0).empty());
}

TEST(ImageReading, SingleSliceIsAVolumeButNoStack) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.nii", NiftiBytes(3, 3, 1).with(std::string(9, '\1')));
  EXPECT_EQ(readVolume(folder / "a.nii").geometry.size[2], 1);
  const Error error = errorOf([&] { readStack(folder / "a.nii"); });
  EXPECT_EQ(error.code(), ErrorCode::UnsupportedImage);
  EXPECT_TRUE(contains(error, "single slice")) << error.what();
  if (std::filesystem::exists(dataFile("G_single_slice.nii.gz"))) {
    EXPECT_EQ(errorOf([] { readStack(dataFile("G_single_slice.nii.gz")); }).code(),
              ErrorCode::UnsupportedImage);
  }
}

TEST(ImageReading, TimeBetweenFrames) {
  const TemporaryFolder folder;
  const auto seconds = [&](int units, int dimensions) {
    writeBytes(folder / "a.nii", NiftiBytes(2, 2, 2)
                                     .set<std::int16_t>(40, static_cast<std::int16_t>(dimensions))
                                     .set<std::int16_t>(48, 3)
                                     .set<float>(92, 250.F)
                                     .set<char>(123, static_cast<char>(units))
                                     .with(std::string(24, '\1')));
    return loadImage(folder / "a.nii", frame(0)).frameSeconds;
  };
  constexpr int mm = 2;
  EXPECT_EQ(seconds(mm | 8, 4), 250);
  EXPECT_DOUBLE_EQ(seconds(mm | 16, 4), 0.25);
  EXPECT_DOUBLE_EQ(seconds(mm | 24, 4), 250e-6);
  EXPECT_EQ(seconds(mm | 32, 4), 0); // Hz
  EXPECT_EQ(seconds(mm, 4), 0);
  EXPECT_EQ(seconds(mm | 8, 3), 0);
  if (std::filesystem::exists(dataFile("G_4d_units_micron_msec.nii.gz"))) {
    EXPECT_NEAR(loadImage(dataFile("G_4d_units_micron_msec.nii.gz"), frame(0)).frameSeconds, 2.2, 1e-6);
  }
}

TEST(ImageReading, TrackedSweepIsTold) {
  const TemporaryFolder folder;
  for (const bool tracked : {false, true}) {
    writeBytes(
        folder / "a.mha",
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\n" +
            std::string(tracked ? "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
                                : "") +
            "ElementDataFile = LOCAL\n" + std::string(8, '\1'));
    EXPECT_EQ(loadImage(folder / "a.mha", {}).tracked, tracked);
    if (tracked) {
      EXPECT_EQ(errorOf([&] { readStack(folder / "a.mha"); }).code(), ErrorCode::UnsupportedImage);
    }
  }
}

TEST(ImageReading, TrackedUltrasoundReadsAsPlain) {
  INNERGS_NEED("F_tracked_us_SpinePhantomFreehand.igs.mha");
  const Volume volume = readVolume(dataFile("F_tracked_us_SpinePhantomFreehand.igs.mha"));
  EXPECT_EQ(volume.geometry.size, (std::array<std::int64_t, 3>{820, 616, 21}));
  EXPECT_EQ(*std::max_element(volume.voxels.begin(), volume.voxels.end()), 251);
}

TEST(ImageReading, Masks) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Volume volume{{{2, 2, 2}, {0, 0, 0}, {1, 1, 1}, {}}, {0, nan, 2, -1, 0.5, 0, 0, 0}};
  writeVolume(volume, folder / "mask.nrrd");
  EXPECT_EQ(readMask(folder / "mask.nrrd").voxels, (std::vector<std::uint8_t>{0, 0, 1, 1, 1, 0, 0, 0}));
  volume.voxels.assign(8, 0);
  writeVolume(volume, folder / "mask.nrrd");
  EXPECT_EQ(errorOf([&] { readMask(folder / "mask.nrrd"); }).code(), ErrorCode::NoData);
}

} // namespace
} // namespace innergs::test
