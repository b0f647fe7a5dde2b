#include "IO/DicomSeries.h"
#include "IO/VolumeIO.h"
#include "SyntheticDicom.h"
#include "TestFiles.h"

#include <algorithm>

namespace fs = std::filesystem;

namespace innergs::test {
namespace {

constexpr const char* series = "G_dicom_mr_T1_oblique";

std::vector<fs::path> files() {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(dataFile(series)))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

TEST(DicomSeries, GeometryAndThickness) {
  INNERGS_NEED(series);
  const Stack stack = readStack(dataFile(series));
  const GridGeometry& g = stack.image.geometry;
  EXPECT_EQ(g.size, (std::array<std::int64_t, 3>{274, 384, 20}));
  EXPECT_NEAR(g.spacing[0], 0.7, 1e-4);
  EXPECT_NEAR(g.spacing[1], 0.6666667, 1e-5);
  EXPECT_NEAR(g.spacing[2], 0.6666667, 1e-4);
  EXPECT_NEAR(stack.thickness, 0.6666667, 1e-4);
  EXPECT_GT(std::abs(g.direction[0][2]) + std::abs(g.direction[1][2]), 1e-3); // oblique
  EXPECT_NEAR(std::abs(determinant(g.direction)), 1, 1e-6);
  EXPECT_EQ(*std::max_element(stack.image.voxels.begin(), stack.image.voxels.end()), 173);
  EXPECT_EQ(stack.name, series);
}

// The same head as NIfTI, converted from the same DICOM files by another program.
TEST(DicomSeries, AgreesWithTheNiftiOfTheSameHead) {
  INNERGS_NEED(series);
  INNERGS_NEED("A_studyforrest_T1w_1mm_crop.nii.gz");
  const Volume slab = readVolume(dataFile(series)),
               head = readVolume(dataFile("A_studyforrest_T1w_1mm_crop.nii.gz"));
  const Affine3 toWorld = slab.geometry.indexToWorld(), toHead = inverse(head.geometry.indexToWorld());
  double n = 0, sumA = 0, sumB = 0, aa = 0, bb = 0, ab = 0;
  for (std::int64_t j = 40; j < 340; j += 3)
    for (std::int64_t i = 30; i < 240; i += 3) {
      const Vec3 index = toHead(toWorld({double(i), double(j), 10}));
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis)
        inside = inside && index[axis] >= 0 && index[axis] <= double(head.geometry.size[axis] - 1);
      if (!inside) continue;
      const double a = slab.voxels[static_cast<std::size_t>(i + 274 * (j + 384 * 10))],
                   b = sampleLinear(head, index);
      n += 1, sumA += a, sumB += b, aa += a * a, bb += b * b, ab += a * b;
    }
  ASSERT_GT(n, 2000);
  const double correlation =
      (n * ab - sumA * sumB) / std::sqrt((n * aa - sumA * sumA) * (n * bb - sumB * sumB));
  EXPECT_GT(correlation, 0.95);
}

TEST(DicomSeries, MissingSlice) {
  INNERGS_NEED(series);
  const TemporaryFolder folder;
  for (const fs::path& file : files())
    if (file.filename() != "N2D_0180.dcm") fs::copy_file(file, folder / file.filename().string());
  const Error error = errorOf([&] { readStack(folder.path()); });
  EXPECT_EQ(error.code(), ErrorCode::Geometry);
  EXPECT_TRUE(contains(error, "evenly spaced")) << error.what();
}

TEST(DicomSeries, OneFileIsASingleSlice) {
  INNERGS_NEED(series);
  EXPECT_EQ(readVolume(files().front()).geometry.size, (std::array<std::int64_t, 3>{274, 384, 1}));
  const Error error = errorOf([&] { readStack(files().front()); });
  EXPECT_EQ(error.code(), ErrorCode::UnsupportedImage);
  EXPECT_TRUE(contains(error, "folder")) << error.what();
}

TEST(DicomSeries, SeveralSeriesAreListed) {
  INNERGS_NEED(series);
  const TemporaryFolder folder;
  int n = 0;
  for (const fs::path& file : files()) {
    std::string bytes = readBytes(file);
    const std::size_t tag =
        bytes.find(std::string("\x20\0\x0e\0", 4)); // (0020,000E), implicit VR: 4 bytes of length follow
    ASSERT_NE(tag, std::string::npos);
    std::uint32_t length;
    std::memcpy(&length, bytes.data() + tag + 4, 4);
    ASSERT_LT(length, 70u);
    if (++n > 10) bytes.replace(tag + 8, 3, "9.9");
    writeBytes(folder / file.filename().string(), bytes);
  }
  const Error error = errorOf([&] { readVolume(folder.path()); });
  EXPECT_EQ(error.code(), ErrorCode::FileFormat);
  EXPECT_TRUE(contains(error, "2 DICOM series") && contains(error, "10 images of 274 x 384")) << error.what();
  EXPECT_TRUE(contains(error, "choose a series: ")) << error.what();
  EXPECT_EQ(readVolume(folder.path(), {.series = 2}).geometry.size[2], 10);
}

Mat3 turned(double angle) { // about the patient's left-right axis
  const double c = std::cos(angle), s = std::sin(angle);
  return {{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}};
}

std::int64_t slices(const fs::path& folder, int series) {
  return readVolume(folder, {.series = series}).geometry.size[2];
}

TEST(DicomFolder, OfSeveralSeriesIsListedAndOneChosen) {
  const TemporaryFolder folder;
  writeDicomStack(folder.path(), "T2 axial", 11, 4, 3.5, 100, {}, {{"0018|0050", "3"}});
  writeDicomStack(folder.path(), "T2 coronal", 12, 5, 2, 200, turned(1.6707963));
  const std::vector<DicomEntry> entries = listDicomSeries(folder.path());
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(textOf(entries[0]), "'T2 axial', 4 images of 6 x 5, axial, 3 mm thick");
  EXPECT_EQ(textOf(entries[1]), "'T2 coronal', 5 images of 6 x 5, coronal tilted by 6 degrees");
  const Error error = errorOf([&] { readVolume(folder.path()); });
  EXPECT_EQ(error.code(), ErrorCode::FileFormat);
  EXPECT_TRUE(contains(error, "holds 2 DICOM series; choose a series: 1: 'T2 axial', 4 images"))
      << error.what();
  EXPECT_EQ(slices(folder.path(), 1), 4);
  EXPECT_EQ(slices(folder.path(), 2), 5);
  const Stack axial = readStack(folder.path(), {.series = 1});
  EXPECT_DOUBLE_EQ(axial.thickness, 3);
  EXPECT_NEAR(axial.image.geometry.spacing[2], 3.5, 1e-6);
  EXPECT_EQ(axial.image.voxels.front(), 100);
  for (const int none : {0, 3}) {
    const Error absent = errorOf([&] { readVolume(folder.path(), {.series = none}); });
    EXPECT_EQ(absent.code(), ErrorCode::InvalidArgument);
    EXPECT_TRUE(contains(absent, "there is no series")) << absent.what();
  }
}

TEST(DicomFolder, StacksOfOneSeriesAreApartWhenTheyLieOtherwise) {
  const TemporaryFolder folder;
  writeDicomStack(folder.path(), "Localiser", 7, 3, 10, 1);
  writeDicomStack(folder.path(), "Localiser", 7, 2, 10, 50, turned(1.5707963));
  ASSERT_EQ(listDicomSeries(folder.path()).size(), 2u);
  EXPECT_EQ(slices(folder.path(), 1) + slices(folder.path(), 2), 5);
}

TEST(DicomFolder, EchoesOfOneSeriesAreApart) {
  const TemporaryFolder folder;
  writeDicomStack(folder.path(), "PD T2", 3, 4, 3, 10, {}, {{"0018|0081", "12"}});
  writeDicomStack(folder.path(), "PD T2", 3, 4, 3, 60, {}, {{"0018|0081", "96"}});
  const std::vector<DicomEntry> entries = listDicomSeries(folder.path());
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(textOf(entries[0]), "'PD T2', echo time 12, 4 images of 6 x 5, axial");
  EXPECT_EQ(entries[1].detail, "echo time 96");
  EXPECT_EQ(readVolume(folder.path(), {.series = 2}).voxels.front(), 60);
}

TEST(DicomFolder, SaysWhenSlicesWereAcquired) {
  const auto times = [](const char* tag, const std::vector<std::string>& said) {
    const TemporaryFolder folder;
    for (std::size_t k = 0; k < said.size(); ++k)
      writeDicomSlice(folder / (std::to_string(k) + ".dcm"), {0, 0, 4.0 * static_cast<double>(k)}, {}, 1,
                      {{"0020|000d", "1.2.3"},
                       {"0020|000e", "1.2.3.4"},
                       {"0008|0018", "1.2.3.4." + std::to_string(k + 1)},
                       {"0018|0050", "4"},
                       {tag, said[k]}});
    const Stack stack = readStack(folder.path());
    EXPECT_EQ(stack.thicknessFrom, "DICOM (0018,0050)");
    return stack.times;
  };
  EXPECT_EQ(times("0008|0032", {"235959.5", "000001.25", "235960", "000003"}),
            (std::vector<double>{86399.5, 86401.25, 86400, 86403}));
  EXPECT_EQ(times("0008|0032", {"101502.25", "101501", "101503"}),
            (std::vector<double>{36902.25, 36901, 36903}));
  EXPECT_EQ(times("0018|1060", {"0", "1500", "500"}), (std::vector<double>{0, 1.5, 0.5}));
  EXPECT_TRUE(times("0008|0032", {"101502", "101502", "101502"}).empty());
  EXPECT_TRUE(times("0020|0012", {"1", "1", "1"}).empty());
}

TEST(DicomFolder, OfOneSeriesNeedsNoChoice) {
  const TemporaryFolder folder;
  writeDicomStack(folder.path(), "", 5, 3, 4, 10, {}, {{"0018|0050", "4.5"}});
  EXPECT_EQ(readVolume(folder.path()).geometry.size[2], 3);
  EXPECT_DOUBLE_EQ(readStack(folder.path()).thickness, 4.5) << "in every locale";
  EXPECT_EQ(slices(folder.path(), 1), 3);
  writeBytes(folder / "notes.txt", "no image");
  EXPECT_EQ(readVolume(folder.path()).geometry.size[2], 3);
}

TEST(DicomSeries, TruncatedFile) {
  INNERGS_NEED(series);
  for (const double part : {0.5, 0.999}) {
    const TemporaryFolder folder;
    for (const fs::path& file : files()) {
      const std::string bytes = readBytes(file);
      const auto kept = static_cast<std::size_t>(part * double(bytes.size()));
      writeBytes(folder / file.filename().string(),
                 file.filename() == "N2D_0180.dcm" ? bytes.substr(0, kept) : bytes);
    }
    const Error error = errorOf([&] { readVolume(folder.path()); });
    EXPECT_EQ(error.code(), ErrorCode::FileFormat);
    EXPECT_TRUE(contains(error, "N2D_0180.dcm")) << error.what();
    EXPECT_EQ(errorOf([&] { readVolume(folder / "N2D_0180.dcm"); }).code(), ErrorCode::FileFormat);
  }
}

} // namespace
} // namespace innergs::test
