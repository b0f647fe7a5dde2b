#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "Core/Base/NumberText.h"
#include "Core/Image/Metrics.h"
#include "IO/VolumeIO.h"

#include <nlohmann/json.hpp>

#include <cmath>

namespace innergs::test {
namespace {

class ModelCommandsTest : public CommandTest {
protected:
  void SetUp() override {
    CommandTest::SetUp();
    writeVolume(truth_, path("scan.nii"));
    // Without a residual grid, which a PLY file leaves out.
    ASSERT_EQ(run(quickly({"reconstruct", path("scan.nii"), "-q", "--no-consistency", "-o", path("volume.nii"), "--save-model",
                           path("m.innergs"), "--ply", path("m.ply")}))
                  .exitCode,
              0)
        << contents("stderr.txt");
  }
  Volume result(std::vector<std::string> arguments, const std::string& name) {
    for (const auto& word : {std::string("-o"), path(name)})
      arguments.push_back(word);
    expectSuccess(run(arguments));
    return readVolume(path(name));
  }
  Volume truth_ = phantom();
};

TEST_F(ModelCommandsTest, ResampleOnTheFittedGrid) {
  const Volume whole = result({"resample", path("m.innergs")}, "out/v.nrrd");
  EXPECT_TRUE(sameGrid(whole.geometry, truth_.geometry));
  const Volume fitted = readVolume(path("volume.nii"));
  ASSERT_EQ(whole.voxels.size(), fitted.voxels.size());
  for (std::size_t n = 0; n < whole.voxels.size(); ++n)
    ASSERT_NEAR(whole.voxels[n], fitted.voxels[n], 0.1);
}

TEST_F(ModelCommandsTest, ResampleFinerOnReferenceAndFromPly) {
  const Volume fine = result({"resample", path("m.innergs"), "--spacing", "0.5"}, "out/fine.nii");
  EXPECT_TRUE(sameGrid(fine.geometry, withSpacing(truth_.geometry, {0.5, 0.5, 0.5})));
  const Volume same =
      result({"resample", path("m.innergs"), "--reference", path("out/fine.nii")}, "out/same.nii");
  EXPECT_TRUE(sameGrid(same.geometry, fine.geometry));
  for (std::size_t n = 0; n < same.voxels.size(); ++n)
    ASSERT_NEAR(same.voxels[n], fine.voxels[n], 0.01);
  const Volume ply = result({"resample", path("m.ply"), "--spacing", "0.5"}, "out/ply.nii");
  for (std::size_t n = 0; n < ply.voxels.size(); ++n)
    ASSERT_NEAR(ply.voxels[n], fine.voxels[n], 0.1);
  expectOneSentence(run({"resample", path("m.innergs"), "--spacing", "0.0003", "-o", path("out/huge.nii")}),
                    1, "GB");
}

// A point has the same value in every plane, and slices lie where they claim to.
TEST_F(ModelCommandsTest, PlanesAgreeWhereTheyMeet) {
  const Vec3 c = truth_.geometry.centre();
  const auto at = [&](const std::string& plane, double position) {
    return result({"slice", path("m.innergs"), "--plane", plane, "--position", formatted("%.6f", position),
                   "--spacing", "0.7"},
                  "out/" + plane + ".nii");
  };
  const Volume axial = at("axial", c[2]), coronal = at("coronal", c[1]), sagittal = at("sagittal", c[0]);
  const auto value = [](const Volume& slice, const Vec3& point) {
    EXPECT_EQ(slice.geometry.size[2], 1);
    const Vec3 index = inverse(slice.geometry.indexToWorld())(point);
    EXPECT_NEAR(index[2], 0, 1e-3) << "the point is not on the slice";
    return sampleLinear(slice, index);
  };
  for (double along = -5; along <= 5; along += 1.3) {
    const Vec3 x{c[0] + along, c[1], c[2]}, y{c[0], c[1] + along, c[2]}, z{c[0], c[1], c[2] + along};
    EXPECT_NEAR(value(axial, x), value(coronal, x), 12); // linear interpolation between 0.7 mm pixels
    EXPECT_NEAR(value(axial, y), value(sagittal, y), 12);
    EXPECT_NEAR(value(coronal, z), value(sagittal, z), 12);
  }
}

TEST_F(ModelCommandsTest, ObliqueSlice) {
  const Vec3 c = truth_.geometry.centre();
  const std::string centre = formatted("%.6f,%.6f,%.6f", c[0], c[1], c[2]);
  const Volume slice = result({"slice", path("m.innergs"), "--normal", "1,1,1", "--center", centre, "--size",
                               "20,10", "--spacing", "0.5"},
                              "out/oblique.nrrd");
  EXPECT_EQ(slice.geometry.size, (std::array<std::int64_t, 3>{20, 10, 1}));
  const Vec3 normal = column(slice.geometry.direction, 2);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(normal[a], std::sqrt(1 / 3.0), 1e-6);
    EXPECT_NEAR(slice.geometry.centre()[a], c[a], 1e-3);
  }
  const Volume byAxes = result(
      {"slice", path("m.innergs"), "--u", "1,0,0", "--v", "0,0.8,0.6", "--origin", centre, "--size", "8"},
      "out/axes.nrrd");
  for (int a = 0; a < 3; ++a)
    EXPECT_NEAR(byAxes.geometry.origin[a], c[a], 1e-3);
  expectOneSentence(
      run({"slice", path("m.innergs"), "--plane", "axial", "--position", "900", "-o", path("out/no.nii")}), 1,
      "beside the model");
  expectOneSentence(
      run({"slice", path("m.innergs"), "--u", "1,0,0", "--v", "1,1,0", "-o", path("out/no.nii")}), 1,
      "right angles");
  EXPECT_FALSE(exists("out/no.nii"));
}

TEST_F(ModelCommandsTest, SliceAsPng) {
  expectSuccess(
      run({"slice", path("m.innergs"), "--plane", "coronal", "--size", "50,40", "-o", path("out/s.png")}));
  const std::string png = contents("out/s.png");
  ASSERT_GT(png.size(), 100u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(png[19], 50); // IHDR: width, height
  EXPECT_EQ(png[23], 40);
  EXPECT_EQ(png[24], 8); // bits
  EXPECT_EQ(png[25], 0); // grey
  expectSuccess(run({"slice", path("m.innergs"), "--plane", "coronal", "--window", "1", "--level", "1e6",
                     "-o", path("out/dark.png")}));
  EXPECT_LT(contents("out/dark.png").size(), png.size()); // all black
}

TEST_F(ModelCommandsTest, InfoOnModelPlyAndImage) {
  const auto model = nlohmann::json::parse(run({"info", path("m.innergs"), "--json"}).out);
  EXPECT_EQ(model.at("kind"), "model");
  EXPECT_GT(model.at("gaussians").get<int>(), 0);
  EXPECT_EQ(model.at("blending"), "normalised");
  EXPECT_EQ(model.at("fit_complete"), true);
  EXPECT_EQ(model.at("domain").at("size"), (std::vector<int>{24, 28, 20}));
  EXPECT_EQ(nlohmann::json::parse(run({"info", path("m.ply"), "--json"}).out).at("gaussians"),
            model.at("gaussians"));
  expectSuccess(run({"resample", path("m.ply"), "--spacing", "2", "-o", path("out/lower.mha")}));
  std::filesystem::copy_file(path("m.ply"), path("M.PLY"));
  std::filesystem::copy_file(path("m.innergs"), path("M.INNERGS"));
  std::filesystem::copy_file(path("scan.nii"), path("SCAN.NII"));
  for (const char* upper : {"M.PLY", "M.INNERGS", "SCAN.NII"})
    EXPECT_EQ(run({"info", path(upper)}).exitCode, 0) << upper;
  expectSuccess(run({"resample", path("M.PLY"), "--spacing", "2", "-o", path("out/UPPER.MHA")}));
  EXPECT_EQ(contents("out/UPPER.MHA"), contents("out/lower.mha"));
  const auto image = nlohmann::json::parse(run({"info", path("scan.nii"), "--json"}).out);
  EXPECT_FALSE(image.contains("slice_thickness_mm"));
  EXPECT_EQ(image.at("kind"), "image");
  EXPECT_EQ(image.at("size"), (std::vector<int>{24, 28, 20}));
  EXPECT_EQ(image.at("axes_grow_towards"), "LPS");
  EXPECT_EQ(image.at("non_finite_voxels"), 0);
  EXPECT_NE(run({"info", path("scan.nii")}).out.find("axes grow towards:"), std::string::npos);
  EXPECT_FALSE(image.contains("slice_thickness_from") || image.contains("slices_acquired"));
  expectOneSentence(run({"info", path("no-such-file")}), 1, "no-such-file");
}

TEST_F(ModelCommandsTest, InfoSaysHowSlicesWereAcquired) {
  writeVolume(phantom({8, 8, 6}, 4), path("thick.nii"));
  write("thick.json", R"({"SliceThickness": 3.5, "SliceTiming": [0, 3, 1, 4, 2, 5]})");
  const auto info = nlohmann::json::parse(run({"info", path("thick.nii"), "--json"}).out);
  EXPECT_EQ(info.at("slice_thickness_mm"), 3.5);
  EXPECT_EQ(info.at("slice_thickness_from"), "SliceThickness in 'thick.json'");
  EXPECT_EQ(info.at("slices_acquired"), "in 2 interleaved passes");
  EXPECT_EQ(info.at("interleaved_passes"), 2);
}

TEST_F(ModelCommandsTest, SimulateThickAndSparse) {
  const Volume thick = result({"simulate", path("scan.nii"), "--thickness", "4"}, "out/thick.nii");
  EXPECT_EQ(thick.geometry.size, (std::array<std::int64_t, 3>{24, 28, 5}));
  EXPECT_NEAR(thick.geometry.spacing[2], 4, 1e-6);
  const std::int64_t plane = 24 * 28;
  for (std::int64_t n = 0; n < plane; n += 13) {
    double mean = 0;
    for (int k = 4; k < 8; ++k)
      mean += truth_.voxels[n + plane * k] / 4;
    EXPECT_NEAR(thick.voxels[n + plane], mean, 0.01);
  }
  expectSuccess(run({"simulate", path("scan.nii"), "--keep-every", "5", "--axis", "coronal", "-o",
                     path("out/sparse.nrrd")}));
  EXPECT_EQ(readStack(path("out/sparse.nrrd")).image.geometry.size[2], 6);
  expectSuccess(run(
      {"simulate", path("scan.nii"), "--thickness", "2", "--orthogonal", "2", "-o", path("out/o.nii.gz")}));
  EXPECT_TRUE(exists("out/o-axial.nii.gz"));
  EXPECT_TRUE(exists("out/o-coronal.nii.gz"));
  EXPECT_FALSE(exists("out/o-sagittal.nii.gz"));
}

TEST_F(ModelCommandsTest, Evaluate) {
  const Outcome outcome =
      run(quickly({"evaluate", path("scan.nii"), "--thickness", "4", "--csv", path("out/t.csv"), "--json",
                   path("out/t.json"), "--picture", path("out/p.png"), "--save-volume", path("out/v.nii"),
                   "--save-model", path("out/m.innergs")}));
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const auto report = nlohmann::json::parse(contents("out/t.json"));
  EXPECT_EQ(report.at("protocol"), "held-out");
  for (const char* method : {"gaussians", "linear", "cubic", "lanczos", "backprojection", "totalvariation"}) {
    const auto& scores = report.at("methods").at(method);
    EXPECT_GT(scores.at("psnr").get<double>(), 5) << method;
    EXPECT_GT(scores.at("ssim").get<double>(), 0) << method;
    EXPECT_TRUE(scores.contains("seconds") && scores.contains("per_plane")) << method;
    EXPECT_NE(outcome.out.find(method), std::string::npos) << outcome.out;
    EXPECT_NE(contents("out/t.csv").find(method), std::string::npos);
  }
  EXPECT_EQ(contents("out/p.png").substr(1, 3), "PNG");
  EXPECT_EQ(readVolume(path("out/v.nii")).geometry.size[2], 20);
  expectSuccess(run({"info", path("out/m.innergs")}));
}

TEST_F(ModelCommandsTest, EvaluateBothProtocols) {
  expectSuccess(run({"evaluate", path("scan.nii"), "--protocol", "both", "--withheld", "0.1",
                     "--baselines-only", "--json", path("out/t.json")}));
  const auto reports = nlohmann::json::parse(contents("out/t.json"));
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_EQ(reports[0].at("protocol"), "held-out");
  EXPECT_EQ(reports[1].at("protocol"), "paper");
  EXPECT_FALSE(reports[1].at("methods").contains("gaussians"));
  EXPECT_GT(reports[1].at("methods").at("linear").at("per_plane").size(), 2u);
}

} // namespace
} // namespace innergs::test
