#include "CommandRunner.h"
#include "SyntheticDicom.h"
#include "SyntheticImages.h"

#include "Core/Base/NumberText.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/Simulate.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"
#include "IO/VolumeIO.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

namespace innergs::test {
namespace {

class ReconstructTest : public CommandTest {
protected:
  std::string scan(const std::string& name, const Volume& volume) {
    writeVolume(volume, path(name));
    return path(name);
  }
  // Runs a fit that must succeed, and returns its volume.
  Volume reconstruct(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "reconstruct");
    for (const auto& word : {std::string("-o"), path("out/v.nii.gz")})
      arguments.push_back(word);
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    return readVolume(path("out/v.nii.gz"));
  }
};

TEST_F(ReconstructTest, TellsWhereSlicesLie) {
  const Volume truth = phantom({40, 40, 40});
  const Stack axial = simulateThickStack(truth, 2, 4), sagittal = simulateThickStack(truth, 0, 4);
  reconstruct({scan("a.nii.gz", axial.image), scan("b.nii.gz", sagittal.image), "--preset", "fast",
               "--iterations", "4", "--slice-motion", "on", "--slices", path("out/slices.tsv"),
               "--transforms", path("out/poses"), "--report", path("out/r.json")});
  const std::string table = contents("out/slices.tsv");
  EXPECT_EQ(table.find("scan\tslice\tweight\tgain\tdisplacement_mm\tangle_degrees\tresidual\tm00\t"), 0u);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 10 + 10);
  const auto motion = nlohmann::json::parse(contents("out/r.json")).at("slice_motion");
  EXPECT_TRUE(motion.at("moved"));
  ASSERT_EQ(motion.at("slices").size(), 20u);
  const auto& slice = motion.at("slices")[13];
  EXPECT_EQ(slice.at("scan"), 2);
  EXPECT_EQ(slice.at("slice"), 3);
  std::istringstream transform(contents("out/poses/scan-2-slice-003.tfm"));
  std::string line;
  for (int n = 0; n < 4; ++n)
    std::getline(transform, line);
  std::istringstream numbers(line.substr(line.find(':') + 1));
  numbers.imbue(std::locale::classic());
  Affine3 back;
  for (auto& row : back.linear.m)
    for (double& x : row)
      numbers >> x;
  for (double& x : back.offset)
    numbers >> x;
  Affine3 place;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      place.linear[row][column] = slice.at("matrix_lps")[row][column];
    place.offset[row] = slice.at("matrix_lps")[row][3];
  }
  const Vec3 x{10, -20, 30};
  EXPECT_LT(norm(back(place(x)) - x), 1e-6); // from tissue to where the header puts the slice
}

TEST_F(ReconstructTest, MovesInterleavedPacketsAsAWhole) {
  const Volume truth = phantom({40, 40, 40});
  const Stack axial = simulateThickStack(truth, 2, 4), sagittal = simulateThickStack(truth, 0, 4);
  reconstruct({scan("a.nii.gz", axial.image), scan("b.nii.gz", sagittal.image), "--preset", "fast",
               "--iterations", "4", "--slice-motion", "on", "--packets", "2", "--report",
               path("out/r.json")});
  const auto report = nlohmann::json::parse(contents("out/r.json"));
  EXPECT_EQ(report.at("settings").at("packets"), 2);
  EXPECT_NE(report.at("warnings").dump().find("in 2 interleaved packets,"), std::string::npos);
  const auto& slices = report.at("slice_motion").at("slices");
  for (std::size_t k = 12; k < 20; ++k)
    EXPECT_EQ(slices[k].at("matrix_lps"), slices[k - 2].at("matrix_lps"));
  EXPECT_NE(slices[11].at("matrix_lps"), slices[10].at("matrix_lps"));
}

TEST_F(ReconstructTest, SaysWhatItAssumesOfTheSlices) {
  const Volume truth = phantom({40, 40, 40});
  const std::string a = scan("a.nii.gz", simulateThickStack(truth, 2, 4).image),
                    b = scan("b.nii.gz", simulateThickStack(truth, 0, 4).image);
  const auto told = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"reconstruct",     a,   b,    "--preset",           "fast",
                                   "--iterations",    "2", "-o", path("out/v.nii.gz"), "--report",
                                   path("out/r.json")};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome.err;
  };
  const auto report = [&] { return nlohmann::json::parse(contents("out/r.json")); };
  const auto inputs = [&] { return report().at("inputs"); };
  const auto says = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(says(told({"--slice-motion", "off"}),
                   "as thick as they lie apart: a.nii.gz (4 mm), b.nii.gz (4 mm). "));
  EXPECT_EQ(inputs()[0].at("thickness_from"), "assumed: the distance between slices");
  EXPECT_FALSE(inputs()[0].at("estimated_thickness").at("statement").get<std::string>().empty());
  EXPECT_EQ(report().at("agreement").at("scans").size(), 2u);
  EXPECT_FALSE(report().at("agreement").at("statement").get<std::string>().empty());
  EXPECT_TRUE(inputs()[0].at("slice_order").is_null());
  EXPECT_FALSE(says(told({"--thickness", "4", "--slice-motion", "off"}), "how thick"));
  EXPECT_EQ(inputs()[1].at("thickness_from"), "--thickness");
  EXPECT_FALSE(says(told({"--profile", "point", "--slice-motion", "off"}), "how thick"));

  write("a.json", R"({"SliceThickness": 3, "SliceTiming": [0, 5, 1, 6, 2, 7, 3, 8, 4, 9]})");
  const std::string interleaved = told({"--mask", scan("m.nii.gz", truth), "--held-out", "0.2"});
  EXPECT_TRUE(says(interleaved, "apart: b.nii.gz (4 mm). ")) << interleaved;
  EXPECT_TRUE(says(interleaved, "a.nii.gz in 2 interleaved passes. --packets 2 moves")) << interleaved;
  EXPECT_EQ(inputs()[0].at("thickness_mm"), 3);
  EXPECT_EQ(inputs()[0].at("thickness_from"), "SliceThickness in 'a.json'");
  EXPECT_EQ(inputs()[0].at("slice_order"), "in 2 interleaved passes");
  EXPECT_FALSE(says(told({"--slice-motion", "off"}), "interleaved"));
  EXPECT_FALSE(says(told({"--packets", "2"}), "--packets"));
  write("b.json", R"({"SliceTiming": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]})");
  EXPECT_TRUE(says(told({}), "b.nii.gz one after the other. --packets, one number"));
}

TEST_F(ReconstructTest, SaysWhatLiesBetweenSlices) {
  const Outcome outcome =
      run({"reconstruct", scan("s.nii.gz", simulateThickStack(phantom({40, 40, 40}), 2, 4).image), "--preset",
           "fast", "--iterations", "5", "-o", path("out/v.nii.gz"), "--report", path("out/r.json")});
  expectSuccess(outcome);
  const auto sentence = nlohmann::json::parse(contents("out/r.json")).at("prediction").get<std::string>();
  EXPECT_FALSE(sentence.empty());
  EXPECT_NE(outcome.err.find(sentence.substr(0, 30)), std::string::npos) << outcome.err;
}

TEST_F(ReconstructTest, WritesEverythingAskedFor) {
  const Volume truth = phantom();
  const Volume volume = reconstruct({scan("scan.nii.gz", truth), "--gaussians", "3000", "--iterations", "40",
                                     "--save-model", path("out/m.innergs"), "--ply", path("out/m.ply"),
                                     "--report", path("out/r.json"), "--seed", "7", "--threads", "2"});
  EXPECT_TRUE(sameGrid(volume.geometry, truth.geometry));
  EXPECT_GT(pooledPsnr(volume.voxels, truth.voxels, {}, 1000), 25);

  const Model model = readModel(path("out/m.innergs"));
  const auto report = nlohmann::json::parse(contents("out/r.json"));
  EXPECT_EQ(report.at("gaussians"), model.field.size());
  EXPECT_LE(model.field.size(), 3000);
  EXPECT_EQ(readPly(path("out/m.ply")).size(), model.field.size());
  EXPECT_EQ(report.at("settings").at("seed"), 7);
  EXPECT_EQ(report.at("settings").at("iterations"), 40);
  EXPECT_EQ(report.at("settings").at("threads"), 2);
  EXPECT_EQ(report.at("settings").at("preset"), "balanced");
  EXPECT_FALSE(report.at("settings").at("instructionSet").get<std::string>().empty());
  EXPECT_EQ(report.at("inputs").size(), 1u);
  EXPECT_EQ(report.at("inputs")[0].at("size"), (std::vector<int>{24, 28, 20}));
  EXPECT_EQ(report.at("output").at("grid").at("size"), (std::vector<int>{24, 28, 20}));
  EXPECT_TRUE(report.at("quality").at("held_out_psnr_db").is_null());
  EXPECT_NE(report.at("quality").at("statement").get<std::string>().find("fitted"), std::string::npos);
  EXPECT_GT(report.at("quality").at("fitted_psnr_db").get<double>(), 25);
  EXPECT_EQ(report.at("non_finite_voxels"), 0);
  EXPECT_FALSE(report.at("interrupted").get<bool>());
  EXPECT_GT(report.at("seconds").at("total").get<double>(), 0);
  for (const char* phase : {"Preparing", "Placing Gaussians", "Fitting", "Rendering"})
    EXPECT_GE(report.at("seconds").at("phases").at(phase).get<double>(), 0) << phase;
  EXPECT_FALSE(report.at("versions").at("itk").get<std::string>().empty());
  EXPECT_EQ(filesIn("out").size(), 4u);
}

TEST_F(ReconstructTest, TakesTheSeriesOfADicomFolderThatIsChosen) {
  const std::filesystem::path folder = folder_ / "dicom";
  writeDicomStack(folder, "T2 axial", 11, 4, 3.5, 100, {}, {{"0018|0050", "3"}});
  writeDicomStack(folder, "T2 thin", 12, 6, 1.5, 200);
  const auto listed = nlohmann::json::parse(run({"info", folder.string(), "--json"}).out);
  EXPECT_EQ(listed.at("kind"), "DICOM folder");
  EXPECT_EQ(listed.at("series").at("1").at("description"), "T2 axial");
  EXPECT_EQ(listed.at("series").at("1").at("slice_thickness_mm"), 3);
  EXPECT_EQ(listed.at("series").at("2").at("images"), 6);
  const auto one = nlohmann::json::parse(run({"info", folder.string(), "--series", "1", "--json"}).out);
  EXPECT_EQ(one.at("slice_thickness_mm"), 3);
  EXPECT_EQ(one.at("spacing_mm")[2], 3.5);

  const std::string output = path("out/v.nrrd");
  expectOneSentence(run(quickly({"reconstruct", folder.string(), "-o", output})), 1,
                    "2: 'T2 thin', 6 images");
  expectOneSentence(run(quickly({"reconstruct", folder.string(), "--series", "3", "-o", output})), 1,
                    "series 3");
  expectOneSentence(run(quickly({"reconstruct", scan("a.nii", phantom()), "--series", "1", "-o", output})), 1,
                    "series");
  expectSuccess(run(quickly({"reconstruct", folder.string(), folder.string(), "--series", "2,1", "--report",
                             path("out/r.json"), "-o", output})));
  const auto inputs = nlohmann::json::parse(contents("out/r.json")).at("inputs");
  EXPECT_EQ(inputs[0].at("size")[2], 6);
  EXPECT_EQ(inputs[1].at("size")[2], 4);
}

#ifdef __linux__
TEST_F(ReconstructTest, AFullDiskIsOneSentence) {
  const std::string small = scan("scan.nii", phantom());
  for (const char* format : {"out/v.nii", "out/v.nii.gz", "out/v.mha", "out/v.nrrd"})
    expectOneSentence(
        run(quickly({"reconstruct", small, "-q", "-o", path(format)}), "trap '' XFSZ; ulimit -f 8; "), 1,
        format);
}
#endif

TEST_F(ReconstructTest, QuietSaysNothing) {
  const Outcome outcome =
      run(quickly({"reconstruct", scan("scan.nii", phantom()), "-q", "-o", path("out/v.mha")}));
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_EQ(outcome.out + outcome.err, "");
  EXPECT_TRUE(exists("out/v.mha"));
}

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(ReconstructTest, GoesOnWithFewerThreadsWhereTheyCannotBeStarted) {
  const std::string small = scan("scan.nii", phantom());
  const Outcome outcome = run({"reconstruct", small, "--preset", "fast", "--gaussians", "400", "--iterations",
                               "6", "--threads", "4096", "-o", path("out/v.mha")},
                              "ulimit -v 2000000; timeout 120 ");
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  expectSuccess(run(quickly({"reconstruct", small, "-o", path("out/two.mha")})));
  EXPECT_EQ(readVolume(path("out/v.mha")).voxels, readVolume(path("out/two.mha")).voxels);
}
#endif

TEST_F(ReconstructTest, PlainProgressLinesWhenNotOnATerminal) {
  const Outcome outcome =
      run(quickly({"reconstruct", scan("scan.nii", phantom()), "-o", path("out/v.nrrd")}));
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos);
  EXPECT_NE(outcome.err.find(" %"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("Wrote " + path("out/v.nrrd")), std::string::npos) << outcome.err;
}

TEST_F(ReconstructTest, ChoosesTheOutputGrid) {
  const Volume truth = phantom();
  const std::string image = scan("scan.nii", truth);
  const Volume coarse = reconstruct(quickly({image, "--spacing", "2,2,4"}));
  EXPECT_TRUE(sameGrid(coarse.geometry, withSpacing(truth.geometry, {2, 2, 4})));

  Volume reference = phantom({10, 11, 12});
  reference.geometry.direction = Mat3{};
  reference.geometry.direction[0][0] = -1; // left-handed
  reference.geometry.origin = truth.geometry.centre();
  const Volume onReference = reconstruct(quickly({image, "--reference", scan("reference.nrrd", reference)}));
  EXPECT_TRUE(sameGrid(onReference.geometry, reference.geometry));
}

TEST_F(ReconstructTest, RegionOfInterest) {
  const Volume truth = phantom();
  const Vec3 c = truth.geometry.centre();
  std::string roi;
  for (const double mm : c)
    roi += (roi.empty() ? "" : ",") + formatted("%.6f,%.6f", mm - 4, mm + 4);
  const Volume part = reconstruct(quickly({scan("scan.nii", truth), "--roi", roi}));
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(part.geometry.centre()[a], c[a], 1);
    EXPECT_GE(part.geometry.size[a], 8);
    EXPECT_LE(part.geometry.size[a], 13); // the box is rotated relative to the grid
  }
}

TEST_F(ReconstructTest, IntegerOutputIsRoundedAndClamped) {
  Volume truth = phantom();
  for (float& voxel : truth.voxels)
    voxel *= 0.25f;
  const std::string image = scan("scan.nii", truth);
  const Volume real = reconstruct(quickly({image}));
  const Volume bytes = reconstruct(quickly({image, "--type", "uint8"}));
  ASSERT_EQ(real.voxels.size(), bytes.voxels.size());
  for (std::size_t n = 0; n < real.voxels.size(); ++n)
    ASSERT_NEAR(bytes.voxels[n], std::clamp(real.voxels[n], 0.0f, 255.0f), 0.5001) << n;
}

TEST_F(ReconstructTest, FusesOrthogonalScans) {
  const Volume truth = phantom({32, 32, 32});
  const std::string image = scan("truth.nii.gz", truth);
  expectSuccess(
      run({"simulate", image, "-q", "--thickness", "4", "--orthogonal", "3", "-o", path("scan.nii.gz")}));
  const auto psnr = [&](const std::vector<std::string>& scans) {
    std::vector<std::string> arguments = scans;
    for (const char* word : {"--gaussians", "4000", "--iterations", "40", "--threads", "2", "--reference"})
      arguments.emplace_back(word);
    arguments.push_back(image);
    return pooledPsnr(reconstruct(arguments).voxels, truth.voxels, {}, 1000);
  };
  const double one = psnr({path("scan-axial.nii.gz")});
  const double three =
      psnr({path("scan-axial.nii.gz"), path("scan-coronal.nii.gz"), path("scan-sagittal.nii.gz")});
  EXPECT_GT(one, 20);
  EXPECT_GT(three, one + 1);
}

TEST_F(ReconstructTest, MaskOnAnotherGridIsResampled) {
  Volume mask = phantom({12, 14, 10});
  mask.geometry = withSpacing(phantom().geometry, {2, 2, 2});
  for (auto& voxel : mask.voxels)
    voxel = voxel > 100;
  reconstruct(quickly({scan("scan.nii", phantom()), "--mask", scan("mask.nii", mask)}));
}

TEST_F(ReconstructTest, EachScanMayHaveItsOwnMask) {
  const Volume truth = phantom({24, 24, 24});
  const std::string a = scan("a.nii", simulateThickStack(truth, 2, 3).image);
  const std::string b = scan("b.nii", simulateThickStack(truth, 0, 3).image);
  Volume large = truth, small = truth;
  for (std::int64_t v = 0; v < truth.geometry.voxelCount(); ++v) {
    const std::int64_t i = v % 24, j = v / 24 % 24, k = v / 576;
    large.voxels[v] = std::min({i, j, k}) >= 6 && std::max({i, j, k}) < 18;
    small.voxels[v] = large.voxels[v] > 0 && j < 12;
  }
  const std::string first = scan("large.nii", large), second = scan("small.nii", small);
  const auto inside = [&](std::vector<std::string> masks) { // masks move with their scans
    masks.insert(masks.begin(), {a, b, "--no-align", "--slice-motion", "off"});
    return reconstruct(quickly(masks));
  };
  const Volume common = inside({"--mask", first});
  const Volume own = inside(
      {"--mask", first, second, "--save-model", path("out/m.innergs"), "--report", path("out/r.json")});
  EXPECT_EQ(own.geometry.size, common.geometry.size) << "the box of both masks";
  EXPECT_NE(own.voxels, common.voxels);
  EXPECT_EQ(inside({"--mask", first, "--mask", second}).voxels, own.voxels);
  EXPECT_EQ(inside({"--mask", first, "--mask", first}).voxels, common.voxels);
  EXPECT_EQ(nlohmann::json::parse(contents("out/r.json")).at("mask"), (nlohmann::json{first, second}));
  const auto info = nlohmann::json::parse(run({"info", path("out/m.innergs"), "--json"}).out);
  EXPECT_EQ(info.at("notes").at("Mask"), "large.nii; small.nii");
}

TEST_F(ReconstructTest, NothingIsInventedOutsideALabelMap) {
  Volume labels = phantom();
  const auto& n = labels.geometry.size;
  for (std::int64_t v = 0; v < labels.geometry.voxelCount(); ++v) {
    const std::int64_t i = v % n[0], j = v / n[0] % n[1], k = v / n[0] / n[1];
    labels.voxels[v] = i >= 8 && i < 15 && j >= 9 && j < 20 && k >= 6 && k < 14 ? 1 + (i > 11) : 0;
  }
  const Volume volume =
      reconstruct(quickly({scan("scan.nii", phantom()), "--mask", scan("labels.nii", labels), "--fill", "-55",
                           "--save-model", path("out/m.innergs"), "--ply", path("out/m.ply")}));
  EXPECT_EQ(volume.geometry.size, (std::array<std::int64_t, 3>{9, 13, 10})) << "the labels' box and a voxel";
  expectSuccess(run({"resample", path("out/m.innergs"), "--reference", path("scan.nii"), "-o",
                     path("out/whole.nii"), "-q"}));
  const Volume whole = readVolume(path("out/whole.nii"));
  ASSERT_EQ(whole.geometry.size, n);
  const ValueRange range = *readModel(path("out/m.innergs")).field.range;
  for (std::int64_t v = 0; v < labels.geometry.voxelCount(); ++v) {
    const std::int64_t i = v % n[0], j = v / n[0] % n[1], k = v / n[0] / n[1];
    const int beyond = (i < 8 || i >= 15) + (j < 9 || j >= 20) + (k < 6 || k >= 14);
    const bool near = i >= 7 && i < 16 && j >= 8 && j < 21 && k >= 5 && k < 15;
    if (beyond <= 1 && near)
      ASSERT_TRUE(whole.voxels[v] >= range.low && whole.voxels[v] <= range.high) << v;
    else
      ASSERT_EQ(whole.voxels[v], -55) << v;
  }
  expectSuccess(run({"slice", path("out/m.innergs"), "--normal", "1,2,3", "-o", path("out/s.nii"), "-q"}));
  const std::vector<float> oblique = readVolume(path("out/s.nii")).voxels;
  EXPECT_GT(std::count(oblique.begin(), oblique.end(), -55.f), 10);
  for (const float v : oblique)
    ASSERT_TRUE(v == -55 || (v >= range.low && v <= range.high));
  expectSuccess(run({"slice", path("out/m.innergs"), "--normal", "1,2,3", "--fill", "-1024", "-o",
                     path("out/f.nii"), "-q"}));
  const std::vector<float> other = readVolume(path("out/f.nii")).voxels;
  for (std::size_t v = 0; v < other.size(); ++v)
    ASSERT_EQ(other[v], oblique[v] == -55 ? -1024 : oblique[v]) << v;
  const auto info = nlohmann::json::parse(run({"info", path("out/m.innergs"), "--json"}).out);
  EXPECT_EQ(info.at("notes").at("Mask"), "labels.nii");
  EXPECT_EQ(info.at("fill_value"), -55);
  EXPECT_NE(info.at("notes").at("Settings").get<std::string>().find("fill=-55"), std::string::npos);
}

TEST_F(ReconstructTest, APlyFileOfAMaskedFitIsWarnedOf) {
  const Outcome outcome = run(quickly(
      {"reconstruct", scan("scan.nii", phantom()), "--mask", path("scan.nii"), "--ply", path("out/m.ply")}));
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("it leaves out the mask of"), std::string::npos) << outcome.err;
  const Outcome filled =
      run({"resample", path("out/m.ply"), "--fill", "0", "-o", path("out/filled.nii"), "-q"});
  EXPECT_EQ(filled.exitCode, 1) << filled.err;
  EXPECT_NE(filled.err.find("omit --fill"), std::string::npos) << filled.err;
}

TEST_F(ReconstructTest, ConstantVolumeWorks) {
  Volume flat = phantom();
  for (auto& voxel : flat.voxels)
    voxel = 41;
  const Volume volume = reconstruct(quickly({scan("flat.nii", flat)}));
  for (const float voxel : volume.voxels)
    ASSERT_NEAR(voxel, 41, 0.5);
}

TEST_F(ReconstructTest, NonFiniteVoxelsAreCountedAndLeftOut) {
  Volume holes = phantom();
  for (std::size_t n = 0; n < 50; ++n)
    holes.voxels[6000 + 17 * n] = n % 2 ? NAN : INFINITY;
  const Volume volume = reconstruct(quickly({scan("holes.nii", holes), "--report", path("out/r.json")}));
  const auto report = nlohmann::json::parse(contents("out/r.json"));
  EXPECT_EQ(report.at("non_finite_voxels"), 50);
  EXPECT_EQ(report.at("inputs")[0].at("non_finite_voxels"), 50);
  EXPECT_FALSE(report.at("warnings").empty());
  for (const float voxel : volume.voxels)
    ASSERT_TRUE(std::isfinite(voxel));
}

TEST_F(ReconstructTest, HeldOutQualityIsThatOfASecondFitAndTheFullOneIsDelivered) {
  const std::string image = scan("scan.nii", phantom()); // 20 slices
  const Volume plain = reconstruct(quickly({image, "--save-model", path("out/plain.innergs")}));
  const Volume judged = reconstruct(quickly({image, "--held-out", "0.2", "--report", path("out/r.json"),
                                             "--save-model", path("out/judged.innergs")}));
  EXPECT_EQ(judged.voxels, plain.voxels);
  EXPECT_EQ(readModel(path("out/judged.innergs")).settingsKey,
            readModel(path("out/plain.innergs")).settingsKey);
  const auto report = nlohmann::json::parse(contents("out/r.json"));
  const auto& quality = report.at("quality");
  EXPECT_EQ(quality.at("held_out_fraction"), 0.2);
  EXPECT_EQ(quality.at("judging"), "done");
  EXPECT_EQ(quality.at("held_out_slices"), 4);
  EXPECT_GT(quality.at("held_out_psnr_db").get<double>(), 10);
  EXPECT_NE(quality.at("statement")
                .get<std::string>()
                .find("dB on 4 held-out slices, from a second fit that did not see them"),
            std::string::npos);
  EXPECT_GT(report.at("seconds").at("judging").get<double>(), 0);
  EXPECT_GT(report.at("seconds").at("phases").at("Judging the quality (second fit)").get<double>(), 0);
}

TEST_F(ReconstructTest, HeldOutFractionsAreRefusedBeforeScansAreRead) {
  for (const char* share : {"0.7", "nan", "-0.1"}) {
    const Outcome outcome =
        run({"reconstruct", path("missing.nii"), "--held-out", share, "-o", path("out/v.nii")});
    EXPECT_NE(outcome.exitCode, 0);
    EXPECT_NE(outcome.err.find("between 0 and 0.5"), std::string::npos) << outcome.err;
  }
  reconstruct(quickly({scan("scan.nii", phantom()), "--held-out", "1e-20", "--report", path("out/r.json")}));
  EXPECT_EQ(nlohmann::json::parse(contents("out/r.json")).at("quality").at("held_out_slices"), 1);
}

TEST_F(ReconstructTest, SameSeedSameBytesOnAnyNumberOfThreads) {
  const std::string image = scan("scan.nii", phantom());
  const auto model = [&](const std::string& name, const std::string& threads) {
    expectSuccess(run({"reconstruct", image, "-q", "--gaussians", "500", "--iterations", "8", "--threads",
                       threads, "--save-model", path(name)}));
    return contents(name);
  };
  EXPECT_EQ(model("one.innergs", "1"), model("three.innergs", "3"));
}

TEST_F(ReconstructTest, FrameOfAMovie) {
  write("movie.nii", niftiBytes({10, 10, 10, 3}, 16, 32));
  const Volume volume = reconstruct(quickly({path("movie.nii"), "--frame", "2"}));
  EXPECT_EQ(volume.geometry.voxelCount(), 1000);
}

TEST_F(ReconstructTest, TrackedSweepNeedsItsCalibration) {
  std::string header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 24 20 6\n"
                       "ElementType = MET_UCHAR\n";
  for (int k = 0; k < 6; ++k)
    header += "Seq_Frame000" + std::to_string(k) + "_ProbeToTrackerTransform = 1 0 0 0 0 0 -1 " +
              std::to_string(k) + " 0 1 0 0 0 0 0 1\n";
  std::string voxels;
  for (int v = 0; v < 24 * 20 * 6; ++v)
    voxels += static_cast<char>(v % 24 > 8 && v % 24 < 16 && v / 24 % 20 > 5 && v / 24 % 20 < 14 ? 100 : 10);
  write("sweep.igs.mha", header + "ElementDataFile = LOCAL\n" + voxels);
  write("probe.txt", "0.5 0 0 1 0 0.5 0 2 0 0 0.5 3 0 0 0 1\n");
  const std::string sweep = path("sweep.igs.mha"), output = path("out.nii");
  expectOneSentence(run(quickly({"reconstruct", sweep, "-o", output})), 1, "ImageToProbe");
  expectOneSentence(run(quickly({"reconstruct", scan("a.nii", phantom()), "--calibration", path("probe.txt"),
                                 "-o", output})),
                    1, "--calibration");
  const auto info =
      nlohmann::json::parse(run({"info", sweep, "--calibration", path("probe.txt"), "--json"}).out);
  EXPECT_EQ(info.at("slices_with_poses"), 6);
  EXPECT_NEAR(info.at("pixel_size_mm").at(0), 0.5, 1e-6);
  const Outcome done = run(quickly({"reconstruct", sweep, "--calibration", path("probe.txt"), "-o", output}));
  EXPECT_EQ(done.exitCode, 0) << done.err;
  const auto made = nlohmann::json::parse(run({"info", output, "--json"}).out);
  EXPECT_GT(made.at("maximum"), 80);
}

} // namespace
} // namespace innergs::test
